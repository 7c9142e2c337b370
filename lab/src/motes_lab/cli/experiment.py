"""`motes-lab experiment`: tables and figures of the papers, reproduced beside their numbers."""

from __future__ import annotations

import difflib
import inspect
from typing import Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE
from motes.core.errors import ConfigError
from motes_lab.cli import (
    experiment_dials,
    experiment_films,
    experiment_maggio,
    experiment_ng_delp,
    experiment_nummiaro,
    experiment_occlusions,
    experiment_zhao_pei,
)

app = App(name="experiment", help_format="plaintext")
for _experiment in (
    experiment_ng_delp.ng_delp_table1,
    experiment_ng_delp.ng_delp_figure3,
    experiment_nummiaro.nummiaro_leaps,
    experiment_nummiaro.two_rooms,
    experiment_nummiaro.handover,
    experiment_nummiaro.nummiaro_figure9,
    experiment_maggio.maggio_figure3,
    experiment_maggio.maggio_rotation,
    experiment_maggio.maggio_growth,
    experiment_zhao_pei.zhao_figure2,
    experiment_zhao_pei.zhao_figure9,
    experiment_zhao_pei.zhao_figure10,
    experiment_zhao_pei.zhao_team,
    experiment_zhao_pei.zhao_detections,
    experiment_occlusions.occlusions,
    experiment_occlusions.real_occlusions,
    experiment_films.pairs,
    experiment_films.moving_camera,
    experiment_dials.dials,
    experiment_films.masks,
    experiment_films.effort,
):
    app.command(_experiment)


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
