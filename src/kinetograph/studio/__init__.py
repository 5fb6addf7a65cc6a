"""The studio: a page on this machine, where a person draws paths, sets keys, chooses leaders and puts sensors on.

`project` is the document, `messages` what page and server say to each other, and `room` and `made` what the sections of
a project work with and give.
"""
