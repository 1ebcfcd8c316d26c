"use strict";
// Colours are the page's own, so that one figure serves light and dark.
const unsent = { sync: false };  // a server, where there is one, need not know
function painted(root) {
  const style = getComputedStyle(document.documentElement);
  const colour = (name) => style.getPropertyValue(`--${name}`).trim();
  const ink = colour("ink"), soft = colour("soft"), line = colour("line");
  const each = {
    Figure: () => ({ background_fill_color: null, border_fill_color: null, outline_line_color: line }),
    Grid: () => ({ grid_line_color: line, grid_line_alpha: 0.6 }),
    Legend: () => ({ background_fill_color: null, label_text_color: ink, inactive_fill_color: colour("paper") }),
    ColorBar: () => ({ background_fill_color: null, title_text_color: ink, major_label_text_color: ink }),
    Axis: () => ({ axis_label_text_color: ink, major_label_text_color: soft, axis_line_color: soft,
      major_tick_line_color: soft, minor_tick_line_color: line }),
  };
  for (const model of root.references()) {
    const kind = model.type.endsWith("Axis") ? "Axis" : model.type;
    if (each[kind]) model.setv(each[kind](), unsent);
    if (kind === "GlyphRenderer" && model.name && model.name.split(" ")[1] !== "image") {
      const found = colour(model.name.replace(" over", "-over").split(" ")[0]);
      if (found) for (const glyph of [model.glyph, model.nonselection_glyph]) {
        const names = ["line_color", "fill_color", "text_color"].filter((name) => glyph && name in glyph.properties);
        if (glyph) glyph.setv(Object.fromEntries(names.map((name) => [name, found])), unsent);
      }
    }
  }
}
