"""What results are shown with: a document and its printers, digits, tables, figures in the colours of a page."""
