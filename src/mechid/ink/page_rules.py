"""Rules of style that several pages have beside those of all."""

COMPACT = """
.answers { grid-template-columns: repeat(auto-fit, minmax(min(24rem, 100%), 1fr)); }
.scroll th, .scroll td { padding: 0.28rem 0.45rem; }
.range { display: block; color: var(--soft); font-size: 0.87em; font-weight: 400; }
@media (max-width: 640px) { table.cards td { overflow-wrap: break-word; } }
"""
ONE_COLUMN = "@media (max-width: 640px) { table.cards tr { grid-template-columns: minmax(0, 1fr); } }"
