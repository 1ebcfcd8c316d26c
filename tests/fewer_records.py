"""A bench's campaign with fewer records: less to read, to validate and to draw where one or two show the same."""


def keep_records(folder, *names):
    """Leave only the named records in the campaign file of a folder; the files of the others stay."""
    path = folder / "campaign.toml"
    head, *records = path.read_text(encoding="utf-8").split("[[record]]")
    kept = [one for one in records if any(f'name = "{name}"' in one for name in names)]
    assert len(kept) == len(names)
    path.write_text("[[record]]".join([head, *kept]), encoding="utf-8")
