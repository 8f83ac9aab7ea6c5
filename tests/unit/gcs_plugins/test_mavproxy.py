"""The MAVProxy module's completion by MAVProxy's own rules; the module itself is loaded in tests/protocol."""

from __future__ import annotations

import warnings
from types import SimpleNamespace

from gcs_plugins.commands import BY_NAME


def test_completion_by_mavproxys_own_rules() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        from MAVProxy.modules.lib import rline

        from gcs_plugins.mavproxy.mavproxy_usv import completions
    rline.rline_mpstate = SimpleNamespace(completion_functions={})
    verbs = rline.complete_rules(completions(), [""])
    assert {"status", "tune", "nudge", *BY_NAME} <= set(verbs)
    assert "dp-surge" in rline.complete_rules(completions(), ["tune", ""])
    assert {"up", "down"} <= set(rline.complete_rules(completions(), ["tune", "path", ""]))
