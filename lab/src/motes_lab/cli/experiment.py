"""`motes-lab experiment`: tables and figures of the papers, reproduced beside their numbers."""

from __future__ import annotations

import difflib
import inspect
from typing import Annotated

from cyclopts import App, Parameter

from motes.cli.exit_codes import DONE
from motes.core.errors import ConfigError
from motes_lab.cli.experiment_camera import moving_camera
from motes_lab.cli.experiment_dials import dials
from motes_lab.cli.experiment_effort import effort
from motes_lab.cli.experiment_maggio import (
    maggio_figure3,
    maggio_growth,
    maggio_rotation,
)
from motes_lab.cli.experiment_masks import masks
from motes_lab.cli.experiment_ng_delp import ng_delp_figure3, ng_delp_table1
from motes_lab.cli.experiment_nummiaro import handover, nummiaro_figure9, nummiaro_leaps, two_rooms
from motes_lab.cli.experiment_occlusions import occlusions, real_occlusions
from motes_lab.cli.experiment_pairs import pairs
from motes_lab.cli.experiment_zhao_pei import (
    zhao_detections,
    zhao_figure2,
    zhao_figure9,
    zhao_figure10,
    zhao_team,
)

app = App(name="experiment", help_format="plaintext")
for _experiment in (
    ng_delp_table1,
    ng_delp_figure3,
    nummiaro_leaps,
    two_rooms,
    handover,
    nummiaro_figure9,
    maggio_figure3,
    maggio_rotation,
    maggio_growth,
    zhao_figure2,
    zhao_figure9,
    zhao_figure10,
    zhao_team,
    zhao_detections,
    occlusions,
    real_occlusions,
    pairs,
    moving_camera,
    dials,
    masks,
    effort,
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
