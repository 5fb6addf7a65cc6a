"""Where the built page is, and what to do where it is missing."""

from __future__ import annotations

from pathlib import Path

from kinetograph.errors import RequestError

PAGE_FILES = ("index.html", "style.css", "studio.js", "player.js")
"""What the page has at least."""

_STUDIO = Path(__file__).parent


def page_folder(studio: Path = _STUDIO) -> Path:
    """
    Return the folder of the built page.

    Parameters
    ----------
    studio : Path
        The folder of the package, with the page in ``page`` and, in a clone, its source in ``client``.

    Returns
    -------
    Path
        The folder that holds ``index.html``, ``style.css``, ``studio.js`` and ``player.js``.

    Raises
    ------
    RequestError
        Where the page is not built or not whole; the text says what is missing and what to do.
    """
    page = studio / "page"
    missing = [name for name in PAGE_FILES if not (page / name).is_file()]
    if not missing:
        return page
    if (studio / "client").is_dir():
        remedy = "run 'make studio', or 'pip install -e .' again, where npm reaches its registry"
    else:
        remedy = "install a wheel that carries it, or from source again where npm reaches its registry, "
        remedy += "with pip's options --force-reinstall --no-cache-dir"
    raise RequestError(f"the studio's page is not built ({page} has no {', '.join(missing)}): {remedy}")
