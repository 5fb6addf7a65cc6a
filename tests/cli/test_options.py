"""Groups of options: what typer reads of a command that takes them, and how its help is laid out."""

from __future__ import annotations

import inspect
from typing import Annotated, get_args

import pytest
import typer
from command_line import answer
from typer.testing import CliRunner

from kinetograph.cli.options import add, expanded, options


@options("Search")
class Search:
    """A group with one option that is required and one that is not."""

    rate: Annotated[float, typer.Option(help="Rate.")]
    beam: Annotated[int | None, typer.Option("-b", "--beam", help="Width.")] = None


@options("Search")
class WiderSearch(Search):
    """The same with one more."""

    name: Annotated[str, typer.Option(rich_help_panel="Names")] = "x"


def command(file: Annotated[str, typer.Argument()], search: WiderSearch, force: bool = False) -> None:
    """Do it."""
    typer.echo(f"{file} {search} {force}")


def test_a_group_is_replaced_by_its_options() -> None:
    parameters = inspect.signature(expanded(command)).parameters
    assert list(parameters) == ["file", "rate", "beam", "name", "force"]
    assert parameters["rate"].default is inspect.Parameter.empty
    assert (parameters["beam"].default, parameters["name"].default) == (None, "x")
    panels = [get_args(parameters[name].annotation)[1].rich_help_panel for name in ("file", "rate", "beam", "name")]
    assert panels == [None, "Search", "Search", "Names"]


def test_a_command_gets_its_groups_back() -> None:
    app = typer.Typer()
    add(app, command)
    done = CliRunner().invoke(app, ["a.csv", "--rate", "2", "-b", "3"])
    assert done.output.strip() == f"a.csv {WiderSearch(rate=2.0, beam=3)} False"
    missing = CliRunner().invoke(app, ["a.csv"])
    assert missing.exit_code == 2
    assert "Missing option '--rate'" in missing.output


def test_two_groups_with_an_option_of_one_name() -> None:
    def twice(one: Search, two: WiderSearch) -> None:
        """Do it."""

    twice.__annotations__ = {"one": Search, "two": WiderSearch}
    with pytest.raises(ValueError, match="duplicate parameter name: 'rate'"):
        expanded(twice)


def test_help_shows_the_common_options_first_and_the_rest_in_boxes() -> None:
    text = answer("perform", "--help").stdout
    titles = [
        "Arguments",
        "Options",
        "Takes of the library",
        "Output",
        "Control",
        "Search",
        "After the search",
        "Reading files",
    ]
    places = [text.index(f"─ {title} ─") for title in titles]
    assert places == sorted(places)
    common = text[places[1] : places[2]]
    assert all(name in common for name in ("--library", "--target", "--mirror", "--help"))
