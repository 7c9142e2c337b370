"""`motes-lab experiment`: tables and figures of the papers, reproduced beside their numbers."""

from __future__ import annotations

import difflib
import inspect
from typing import Annotated

from cyclopts import App, Parameter

from motes import ConfigError
from motes.cli import DONE
from motes_lab.effort.experiment import effort
from motes_lab.papers.handover import handover
from motes_lab.papers.maggio_figure3 import maggio_figure3
from motes_lab.papers.ng_delp_figure3 import ng_delp_figure3
from motes_lab.papers.ng_delp_table1 import ng_delp_table1
from motes_lab.papers.nummiaro_figure9 import nummiaro_figure9
from motes_lab.papers.pairs import pairs
from motes_lab.papers.real_occlusions import real_occlusions
from motes_lab.papers.zhao_pei_detections import zhao_detections
from motes_lab.papers.zhao_pei_figure9 import zhao_figure9
from motes_lab.papers.zhao_pei_figure10 import zhao_figure10
from motes_lab.papers.zhao_pei_team import zhao_team

app = App(name="experiment", help_format="plaintext")
for _experiment in (
    ng_delp_table1, ng_delp_figure3, handover, nummiaro_figure9, maggio_figure3, zhao_figure9,
    zhao_figure10, zhao_team, zhao_detections, real_occlusions, pairs, effort,
):  # fmt: skip
    app.command(_experiment)


@app.default
def experiment(*name: Annotated[str, Parameter(show=False, allow_leading_hyphen=True)]) -> int:
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
