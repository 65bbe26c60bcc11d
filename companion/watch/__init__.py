"""The live page: a process of its own that reads what the companions of this computer publish, and serves it.

flights   what is published, and the trail that was seen
server    the page and its stream of words, over HTTP (needs the extra ``watch``)
page.html all of the page: no network resource

Nothing here reaches a companion: it only reads files.
"""
