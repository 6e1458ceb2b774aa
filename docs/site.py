"""Make the pages of the site that come from other files: README, pictures, notebooks, docstrings."""

import importlib.util
import os
import re
import tempfile
from pathlib import Path

import nbformat
from mkdocs.structure.files import File, Files
from mkdocs.structure.nav import Section
from nbclient import NotebookClient
from nbconvert import MarkdownExporter
from reference import REFERENCE
from traitlets.config import Config
from typer.testing import CliRunner

from walkergen.cli import command_line
from walkergen.command_table import COMMANDS

ROOT = Path(__file__).parent.parent
COMMAND_NAMES = list(COMMANDS)
"""Commands, in the order of the help."""

PROJECT_PAGES = {"index.md": "README.md", "contributing.md": "CONTRIBUTING.md", "changelog.md": "CHANGELOG.md"}
"""Pages made from files of the project. Their links to docs/ become links within the site."""


def on_files(files, config):
    """Add the generated pages."""
    made = {page: _convert_links(ROOT / name) for page, name in PROJECT_PAGES.items()}
    made["pictures.md"] = _make_picture_list()
    for notebook in sorted((ROOT / "examples").glob("*.ipynb")):
        made |= _run_notebook(notebook)
    made |= {f"commands/{name}.md": _make_command_page(name) for name in COMMAND_NAMES}
    made |= {f"api/{page}.md": _make_reference_page(page) for page in REFERENCE}
    for page, text in made.items():
        files.append(File.generated(config, page, content=text))
    return Files([file for file in files if not file.src_path.endswith(".py")])


def on_page_markdown(markdown, page, config, files):
    """Point links to notebooks at their pages."""
    return re.sub(r"\]\(\.\./(examples/[\w-]+)\.ipynb\)", r"](\1.md)", markdown)


def _convert_links(path):
    """Return a file of the project as a page. Links to files outside docs/ become text."""
    text = re.sub(r"\[([^]]+)\]\((?!https?:|#|docs/)[^)]+\)", r"\1", path.read_text(encoding="utf-8"))
    return re.sub(r"\]\(docs/", "](", text)


def _make_picture_list():
    """Return a page of all pictures, each with its title and its command."""
    pages = [ROOT / "README.md", *sorted((ROOT / "docs").glob("**/*.md"))]
    text = "".join(page.read_text(encoding="utf-8") for page in pages)
    captions = {name: words for words, name in re.findall(r"!\[(.*?)\]\((?:docs/|\.\./)?(.*?)\)", text)}
    commands = {one.name: one.shown or one.command for one in _load_pictures().PICTURES}
    return "# Pictures\n\n" + "\n\n".join(
        f"## {words}\n\n![{words}]({name})\n\n```sh\n{commands[name]}\n```" for name, words in captions.items()
    )


def _load_pictures():
    """Load docs/pictures.py, even if another module has the same name."""
    spec = importlib.util.spec_from_file_location("docs_pictures", ROOT / "docs" / "pictures.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def _run_notebook(path):
    """Run a notebook with this code. Return its page and its pictures by name."""
    notebook = nbformat.read(path, as_version=4)
    quiet = Config({"KernelManager": {"transport_encryption": "auto"}})  # else it warns of TCP
    with tempfile.TemporaryDirectory() as folder:
        client = NotebookClient(notebook, resources={"metadata": {"path": folder}}, config=quiet)
        client.execute(env={**os.environ, "PYTHONPATH": str(ROOT)})
    text, made = MarkdownExporter().from_notebook_node(notebook, {"unique_key": path.stem})
    return {f"examples/{name}": data for name, data in made["outputs"].items()} | {
        f"examples/{path.stem}.md": text.replace("![png]", "![Figure]")
    }


def _make_reference_page(page):
    """Return a page of the reference: each object by the name that people use."""
    text, paths = REFERENCE[page]
    for path in paths:
        name = path.rpartition(".")[2]
        heading = f"wg.{name}" if page == "python" else name
        text += f"\n\n::: {path}\n    options: {{heading: {heading}, toc_label: {name}}}"
    return text


def _make_command_page(name):
    """Return the page of a command: its help and the help of its subcommands."""
    texts = [_read_help(name)]
    for under in re.findall(r"^  (\w+)  ", texts[0].partition("Commands:\n")[2], flags=re.MULTILINE):
        texts.append(_read_help(name, under))
    return f"# {name}\n\n" + "\n\n".join(f"```text\n{text}\n```" for text in texts)


def _read_help(*words):
    text = CliRunner().invoke(command_line, [*words, "-h"], prog_name="walkergen", env={"COLUMNS": "88"})
    assert text.exit_code == 0, text.output
    return text.stdout.strip()


def on_nav(nav, config, files):
    """Add commands and reference after the written pages."""
    for title, names in (
        ("Commands", [f"commands/{name}.md" for name in COMMAND_NAMES]),
        ("Reference", [f"api/{page}.md" for page in REFERENCE]),
    ):
        nav.items.append(Section(title, [files.get_file_from_path(name).page for name in names]))
    return nav
