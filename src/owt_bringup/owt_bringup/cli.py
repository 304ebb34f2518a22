"""The command line ``owt``: parses, calls one function per command, prints one line on bad input."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from importlib import import_module

from owt_bringup.startup import start_quickly
from owt_model.errors import OwtError

__all__ = ["main"]

#: Command -> module with ``HELP``, ``add_arguments(parser)`` and ``run(arguments) -> int``.
COMMANDS = {
    "demo": "owt_bringup.commands.demo",
    "serve": "owt_bringup.commands.serve",
    "view": "owt_bringup.commands.view",
    "sea": "owt_bringup.commands.sea",
    "waves": "owt_bringup.commands.waves",
    "loads": "owt_bringup.commands.loads",
    "eigen": "owt_bringup.commands.eigen",
    "simulate": "owt_bringup.commands.simulate",
    "campaign": "owt_bringup.commands.campaign",
    "table": "owt_bringup.commands.table",
    "superelement": "owt_bringup.commands.superelement",
    "study": "owt_bringup.commands.study",
    "analyse": "owt_bringup.commands.analyse",
    "report": "owt_bringup.commands.report",
    "replay": "owt_bringup.commands.replay",
    "recover": "owt_bringup.commands.recover",
}


class _Parser(argparse.ArgumentParser):
    """Reports a wrong command line in the same one-line form as any other bad input."""

    def error(self, message: str) -> None:  # type: ignore[override]
        """Exit with one line."""
        self.exit(2, f"error: {message}. See `{self.prog} --help`.\n")


def _parser(command: str | None) -> argparse.ArgumentParser:
    """Build the parser; only the named command's module is imported."""
    parser = _Parser(prog="owt", description="Fatigue loads of offshore wind turbine jackets.")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND", parser_class=_Parser)
    for name, module_name in COMMANDS.items():
        if command is not None and name != command:
            continue
        module = import_module(module_name)
        sub = commands.add_parser(name, help=module.HELP, description=module.HELP)
        module.add_arguments(sub)
        sub.set_defaults(run=module.run)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; return its exit code."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    command = arguments[0] if arguments and arguments[0] in COMMANDS else None
    try:
        options = _parser(command).parse_args(arguments)
        start_quickly()
        return int(options.run(options))
    except OwtError as error:
        return _fail(str(error))
    except KeyboardInterrupt:
        return _fail("interrupted", code=130)
    except BrokenPipeError:
        return 1
    except OSError as error:
        place = f" ({error.filename})" if error.filename else ""
        return _fail(f"{error.strerror or error}{place}. Check the path, its permissions and the free space.")
    except MemoryError:
        return _fail("out of memory. Use fewer samples, points or components.")


def _fail(message: str, code: int = 1) -> int:
    """Print one line and return `code`."""
    print("error: " + " ".join(message.split()), file=sys.stderr)
    return code


if __name__ == "__main__":
    sys.exit(main())
