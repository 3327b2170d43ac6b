"""The documentation site: make docs, or python -m sphinx -W -b html docs docs/_build/html"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING

from pygments.lexers.special import TextLexer
from sphinx.highlighting import lexers

import microslip

if TYPE_CHECKING:
    from sphinx.application import Sphinx

ROOT = Path(__file__).parents[1]

project = "microslip"
author = "microslip contributors"
copyright = author
version = release = microslip.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
root_doc = "index"
lexers["csv"] = TextLexer()  # Pygments knows none
exclude_patterns = ["_build", "make_images.py", "gallery/**.ipynb"]
suppress_warnings = ["config.cache"]  # the key functions of the gallery are not pickled

# Nothing is fetched: no other sites' inventories, no fonts, no MathJax. Formulas are plain text.
html_theme = "pydata_sphinx_theme"
html_title = f"microslip {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_sidebars = {name: [] for name in ("index", "get-started", "contributing", "changelog")}
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "navigation_with_keys": False,
    "show_prev_next": False,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "header_links_before_dropdown": 5,
    "show_toc_level": 2,
}

myst_heading_anchors = 4

napoleon_google_docstring = False
napoleon_use_rtype = False
autodoc_typehints = "none"
autodoc_member_order = "groupwise"
autosummary_generate = True
toc_object_entries_show_parents = "hide"

templates_path = ["_templates"]

sphinx_gallery_conf = {
    "examples_dirs": ["../examples"],
    "gallery_dirs": ["gallery"],
    "filename_pattern": r"\.py$",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "write_computation_times": False,
    "min_reported_time": 1e9,
    "show_signature": False,
    "run_stale_examples": True,
    "backreferences_dir": "gallery/backreferences",
    "doc_module": ("microslip",),
    "abort_on_example_error": True,
    "image_scrapers": ("matplotlib",),
    "copyfile_regex": r".*\.(toml|csv|npy)$",
    "remove_config_comments": True,
}

# Pages that live at the top of the repository, where readers of the code look for them.
TOP_PAGES = {"contributing": ROOT / "CONTRIBUTING.md", "changelog": ROOT / "CHANGELOG.md"}
LINKS = {
    "../README.md": "get-started.md",
    "../examples": "gallery/index.rst",
    "examples": "gallery/index.rst",
    "../CONTRIBUTING.md": "contributing.md",
    "../CHANGELOG.md": "changelog.md",
    "CHANGELOG.md": "changelog.md",
}


def read_top_pages(app: Sphinx, docname: str, source: list[str]) -> None:
    """Put in the pages of the repository's top, and turn links to them to the site's own."""
    if docname in TOP_PAGES:
        source[0] = TOP_PAGES[docname].read_text(encoding="utf-8").replace("](docs/", "](")

    def turned(link: re.Match[str]) -> str:
        text, target, anchor = link.groups(default="")
        # Where the text is the name of the file, the site has the title of the page or section.
        text = "" if text.endswith(".md") and text.rpartition("/")[2] in target else text
        return f"[{text}]({LINKS.get(target, target)}{anchor})"

    if Path(app.env.doc2path(docname)).suffix == ".md":
        link = r"\[([^\]]*)\]\(([^)\s#]+)(#[^)\s]*)?\)"
        source[0] = re.sub(link, turned, source[0])


def keep_bars(
    app: Sphinx, kind: str, name: str, item: object, options: object, lines: list[str]
) -> None:
    """Docstrings write sizes as one does, |T|; reStructuredText takes that for something else."""
    for number, line in enumerate(lines):
        pieces = re.split(r"(`[^`]*`)", line)
        lines[number] = "".join(p if p.startswith("`") else p.replace("|", r"\|") for p in pieces)


def add_explorer(app: Sphinx, error: Exception | None) -> None:
    """The page with sliders lies beside the others."""
    if error is None and app.builder.format == "html":
        from microslip.app.explorer.page import page

        Path(app.outdir, "explorer.html").write_text(page(), encoding="utf-8")


def setup(app: Sphinx) -> None:
    """Called by Sphinx."""
    app.connect("source-read", read_top_pages)
    app.connect("autodoc-process-docstring", keep_bars)
    app.connect("build-finished", add_explorer)
