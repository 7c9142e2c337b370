"""`motes experiment`: tables and figures of the papers, reproduced beside their numbers."""

from __future__ import annotations

import difflib
import inspect
from typing import Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE
from motes.core.errors import ConfigError

app = App(name="experiment", help_format="plaintext")
app.command("motes.cli.experiment_ng_delp:ng_delp_table1", name="ng-delp-table1")
app.command("motes.cli.experiment_ng_delp:ng_delp_figure3", name="ng-delp-figure3")
app.command("motes.cli.experiment_nummiaro:nummiaro_leaps", name="nummiaro-leaps")
app.command("motes.cli.experiment_nummiaro:two_rooms", name="two-rooms")
app.command("motes.cli.experiment_nummiaro:nummiaro_figure9", name="nummiaro-figure9")
app.command("motes.cli.experiment_maggio:maggio_table1", name="maggio-table1")
app.command("motes.cli.experiment_maggio:maggio_figure5", name="maggio-figure5")
app.command("motes.cli.experiment_maggio:maggio_rotation", name="maggio-rotation")
app.command("motes.cli.experiment_maggio:maggio_growth", name="maggio-growth")
app.command("motes.cli.experiment_zhao_pei:zhao_figure2", name="zhao-figure2")
app.command("motes.cli.experiment_zhao_pei:zhao_figure9", name="zhao-figure9")
app.command("motes.cli.experiment_zhao_pei:zhao_figure10", name="zhao-figure10")
app.command("motes.cli.experiment_zhao_pei:zhao_detections", name="zhao-detections")
app.command("motes.cli.experiment_zhao_pei:occlusions", name="occlusions")


@app.default
def experiment(
    *name: Annotated[str, Parameter(show=False, allow_leading_hyphen=True)],
    list: Annotated[  # noqa: A002
        bool, Parameter(negative=(), show_default=False, help="List the experiments.")
    ] = False,
) -> int:
    """Reproduce tables and figures of the papers, beside the papers' numbers.

    Without a name, list the experiments. motes track --figures draws further figures: Nummiaro et
    al., figures 3, 7, 12 and 14, and Maggio et al., figures 1 and 3.
    """
    known = {each: app[each].default_command for each in app if not each.startswith("-")}
    if name:
        near = difflib.get_close_matches(name[0], known, n=1)
        hint = f"did you mean {near[0]}?" if near else f"known are {', '.join(known)}."
        raise ConfigError(f"There is no experiment {name[0]}; {hint}")
    for each, command in known.items():
        print(f"{each:<18}{(inspect.getdoc(command) or '').splitlines()[0]}")
    return DONE
