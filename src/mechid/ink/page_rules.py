"""Style rules shared by some pages."""

COMPACT = """
.answers { grid-template-columns: repeat(auto-fit, minmax(min(24rem, 100%), 1fr)); }
.scroll th, .scroll td { padding: 0.28rem 0.45rem; }
.range { display: block; color: var(--soft); font-size: 0.87em; font-weight: 400; }
@media (max-width: 640px) { table.cards td { overflow-wrap: break-word; } }
"""
ONE_COLUMN = "@media (max-width: 640px) { table.cards tr { grid-template-columns: minmax(0, 1fr); } }"
CARDS = """
.shelf {
  display: grid; grid-template-columns: repeat(auto-fill, minmax(min(21rem, 100%), 1fr)); gap: 1rem; margin: 0.8rem 0;
}
.card {
  min-width: 0; padding: 0.7rem 1rem 0.9rem; background: var(--raised); border-radius: 0.4rem;
  border-left: 5px solid var(--tone, var(--line));
}
.card.good { --tone: var(--good); } .card.caution { --tone: var(--caution); } .card.bad { --tone: var(--bad); }
.card h3 { margin: 0; } .card .soft { margin: 0; font-size: 0.86rem; } .card ul { font-size: 0.92rem; }
.card .headline { color: var(--tone, inherit); font-weight: 600; }
.card p.caution { color: var(--caution); font-weight: 600; }
.card img {
  display: block; width: 100%; max-height: 13rem; object-fit: cover; object-position: top; margin: 0.5rem 0;
  background: #fff; border-radius: 0.25rem;
}
.card pre { margin: 0.5rem 0 0; font-size: 0.8rem; white-space: pre-wrap; }
:root[data-theme="dark"] .card img { filter: invert(0.9) hue-rotate(180deg); }
@media (prefers-color-scheme: dark) { :root:not([data-theme]) .card img { filter: invert(0.9) hue-rotate(180deg); } }
"""
