"""Build the site: put its pages together, let Sphinx make them, and follow every link.

python docs/build.py [--out FOLDER] [--no-pictures]
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from builder import check, gallery, language, pictures, reference, source_pages, stage, stand_ins
from sphinx.cmd.build import build_main

HERE = Path(__file__).parent
ROOT = HERE.parent


def main() -> int:
    """Build it; return 1 where a page has a mistake."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=ROOT / "build" / "site", help="folder for the site")
    parser.add_argument("--no-pictures", action="store_true", help="draw no level and film none: quick, for a try")
    asked = parser.parse_args()
    source = ROOT / "build" / "site-source"
    generated = {**language.pages(), **reference.pages()}
    generated |= gallery.pages(source, pictures=not asked.no_pictures)
    stage.stage(ROOT, source, generated)
    (source / pictures.EXTRA).mkdir(exist_ok=True)
    options = ["-W", "--keep-going", "-q", "-j", "auto", "-b", "html", "-c", str(HERE)]
    options += ["-d", str(ROOT / "build" / "site-doctrees")]
    with stand_ins.stood_in():
        if status := build_main([*options, str(source), str(asked.out)]):
            return int(status)
    source_pages.mend(asked.out)
    broken = check.broken_links(asked.out)
    print("\n".join(broken) or f"{asked.out / 'index.html'}")
    return int(bool(broken))


if __name__ == "__main__":
    sys.exit(main())
