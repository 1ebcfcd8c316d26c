"""Files with objects of MATLAB's classes as MATLAB writes them, versions 7 and 7.3, from a tree of Python values.

Laid out as the files of R2024b under stepper_encoder of the measured data, and as N. Lakshmisha's mat-io describes it
(docs/subsystem_data_format.md). A dict is a struct, a list a cell, `Obj` an object; arrays, texts as they are.
"""

import struct
from dataclasses import dataclass, field
from itertools import chain

import numpy as np

MAGIC = 0xDD000000
VERSION = 4
"""Of the table of objects."""


SELF = np.array([MAGIC, 2, 1, 1, 1, 1], np.uint32)[:, None]
"""A reference to the first object of a file."""


@dataclass
class Obj:
    """An object; `saved` is one whose class writes itself as a struct, the property `any`."""

    kind: str
    properties: dict
    saved: bool = False


@dataclass
class Heap:
    """Objects and cells of a file, numbered as they come."""

    names: list = field(default_factory=list)
    kinds: list = field(default_factory=list)
    objects: list = field(default_factory=list)
    cells: list = field(default_factory=list)

    def name(self, text):
        """Return the number of a name, from 1; 0 is none."""
        if text and text not in self.names:
            self.names.append(text)
        return self.names.index(text) + 1 if text else 0

    def words(self, thing):
        """Keep an object; return the words of a reference to it, (6, 1)."""
        if thing.kind not in self.kinds:
            self.kinds.append(thing.kind)
        number = len(self.objects)
        self.objects.append(None)
        listed = []
        for key, value in thing.properties.items():
            kept = self.replaced(value)
            self.cells.append(kept)
            listed += [self.name(key), 1, len(self.cells) - 1]
        self.objects[number] = (self.kinds.index(thing.kind) + 1, thing.saved, listed)
        return np.array([MAGIC, 2, 1, 1, number + 1, self.kinds.index(thing.kind) + 1], np.uint32)[:, None]

    def replaced(self, value):
        """Return a tree whose objects are references."""
        if isinstance(value, Obj):
            return self.words(value)
        if isinstance(value, dict):
            return {key: self.replaced(part) for key, part in value.items()}
        return [self.replaced(part) for part in value] if isinstance(value, list) else value

    def table(self):
        """Return the first cell, (n, 1) bytes."""
        classes = [0, 0, 0, 0]
        for kind in self.kinds:
            space, _, last = kind.rpartition(".")
            classes += [self.name(space), self.name(last), 0, 0]
        saved, plain, objects = [[0, 0]], [[0, 0]], [0] * 6
        for kind, is_saved, listed in self.objects:
            block = [len(listed) // 3, *listed]
            (saved if is_saved else plain).append(block + [0] * (len(block) % 2))
            places = (len(saved) - 1, 0) if is_saved else (0, len(plain) - 1)
            objects += [kind, 0, 0, *places, 0]
        text = b"".join(name.encode() + b"\0" for name in self.names)
        text += bytes(-len(text) % 8)
        regions = [classes, [*chain(*saved)], objects, [*chain(*plain)], [0, 0]]
        offsets = np.cumsum([40 + len(text), *(4 * len(region) for region in regions), 0, 0]).tolist()
        head = struct.pack("<10I", VERSION, len(self.names), *offsets)
        blob = head + text + b"".join(struct.pack(f"<{len(region)}I", *region) for region in regions)
        return np.frombuffer(blob, np.uint8)[:, None]

    def all_cells(self):
        """Return the cells of the table of objects, in order."""
        return [self.table(), np.empty((0, 0)), *self.cells, [], np.zeros((len(self.kinds) + 1, 1), np.int32), []]


def write_73(path, variables):
    """Write objects as a file of version 7.3."""
    import h5py

    heap = Heap()
    references = {name: heap.words(thing) for name, thing in variables.items()}
    with h5py.File(path, "w", userblock_size=512) as file:
        place = file.create_group("#refs#")

        def put(value, group, key):
            if isinstance(value, dict):
                node = group.create_group(key)
                node.attrs["MATLAB_class"] = np.bytes_("struct")
                for name, part in value.items():
                    put(part, node, name)
                return
            kind = {"f": "double", "U": "char", "u": f"uint{8 * np.asarray(value).itemsize}", "i": "int32"}
            if isinstance(value, list):
                for k, part in enumerate(value):
                    put(part, place, f"{key}_{group.name.strip('/#')}_{k}".replace("/", "_"))
                made = [place[f"{key}_{group.name.strip('/#')}_{k}".replace("/", "_")].ref for k in range(len(value))]
                node = group.create_dataset(key, data=np.array(made, h5py.ref_dtype)[None], dtype=h5py.ref_dtype)
                node.attrs["MATLAB_class"] = np.bytes_("cell")
                return
            if isinstance(value, str):
                value = np.array([[ord(letter)] for letter in value], np.uint16)
                group[key] = value
                group[key].attrs["MATLAB_class"] = np.bytes_("char")
                return
            value = np.asarray(value)
            group[key] = value.T if value.size else np.zeros(2, np.uint64)
            group[key].attrs["MATLAB_class"] = np.bytes_(kind[value.dtype.kind])
            if not value.size:
                group[key].attrs["MATLAB_empty"] = np.uint8(1)

        cells = heap.all_cells()
        for k, cell in enumerate(cells):
            put(cell, place, f"cell{k}")
        made = np.array([place[f"cell{k}"].ref for k in range(len(cells))], h5py.ref_dtype)[None]
        heap_node = file.create_dataset("#subsystem#/MCOS", data=made, dtype=h5py.ref_dtype)
        heap_node.attrs["MATLAB_class"] = np.bytes_("FileWrapper__")
        for name, words in references.items():
            file[name] = words.T
            file[name].attrs["MATLAB_class"] = np.bytes_(variables[name].kind)
            file[name].attrs["MATLAB_object_decode"] = np.int32(3)
    with path.open("r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file, written by a test".ljust(512))


def write_7(path, variables):
    """Write objects as a file of version 7, uncompressed."""
    heap = Heap()
    references = {name: heap.words(thing) for name, thing in variables.items()}
    opaque = b"".join(_opaque(name, variables[name].kind, words) for name, words in references.items())
    wrapper = _opaque("", "FileWrapper__", heap.all_cells())
    keys = _element(5, struct.pack("<i", 5)) + _element(1, b"MCOS\0")
    inner = b"\0\1IM\0\0\0\0" + _matrix(2, (1, 1), "", keys + wrapper)
    head = b"MATLAB 5.0 MAT-file, written by a test".ljust(116) + struct.pack("<Q", 128 + len(opaque)) + b"\0\1IM"
    path.write_bytes(head + opaque + _value(np.frombuffer(inner, np.uint8)[None], ""))


def write_compact_mat(path, **variables):
    """Write vectors of doubles as MATLAB does: whole numbers below 256 as bytes, which are doubles all the same."""
    parts = []
    for name, values in variables.items():
        is_compact = np.all((values == np.round(values)) & (values >= 0) & (values < 256))
        stored = (2, values.astype(np.uint8)) if is_compact else (9, values)
        parts.append(_matrix(6, (values.size, 1), name, _element(stored[0], stored[1].tobytes())))
    path.write_bytes(b"MATLAB 5.0 MAT-file, written by a test".ljust(116) + bytes(8) + b"\0\1IM" + b"".join(parts))


def _element(kind, data):
    return struct.pack("<II", kind, len(data)) + data + bytes(-len(data) % 8)


def _matrix(kind, shape, name, body):
    flags = _element(6, struct.pack("<II", kind, 0))
    dimensions = _element(5, struct.pack(f"<{len(shape)}i", *shape))
    return _element(14, flags + dimensions + _element(1, name.encode()) + body)


def _opaque(name, kind, value):
    texts = b"".join(_element(1, text.encode()) for text in (name, "MCOS", kind))
    return _element(14, _element(6, struct.pack("<II", 17, 0)) + texts + _value(value, ""))


def _value(value, name):
    if isinstance(value, list):
        return _matrix(1, (len(value), 1), name, b"".join(_value(part, "") for part in value))
    if isinstance(value, dict):
        keys = b"".join(key.encode().ljust(32, b"\0") for key in value)
        parts = b"".join(_value(part, "") for part in value.values())
        return _matrix(2, (1, 1), name, _element(5, struct.pack("<i", 32)) + _element(1, keys) + parts)
    if isinstance(value, str):
        return _matrix(4, (1, len(value)), name, _element(4, value.encode("utf-16-le")))
    value = np.asarray(value)
    kind, stored = {"f8": (6, 9), "u1": (9, 2), "u4": (13, 6), "i4": (12, 5)}[value.dtype.str[1:]]
    return _matrix(kind, value.shape, name, _element(stored, value.tobytes(order="F")))
