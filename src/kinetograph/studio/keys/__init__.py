"""The section of keys: poses to go through, hands and feet put elsewhere, spans that are kept."""
