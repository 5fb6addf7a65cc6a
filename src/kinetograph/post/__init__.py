"""What happens to chosen pieces afterwards: blending, contacts, footskate cleanup (Hsu 2004, chapter 5, and beyond)."""
