"""Build hook: a wheel that carries compiled kernels is for one platform and one version of Python."""

from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface


class PlatformWheel(BuildHookInterface[Any]):
    """Tags the wheel where `telemotion compile --into estimators/_compiled` has run before."""

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Set the tag; an editable installation compiles for its own processor and has none."""
        if version != "editable" and (Path(self.root) / "estimators" / "_compiled" / "built.json").is_file():
            build_data["pure_python"] = False
            build_data["infer_tag"] = True
