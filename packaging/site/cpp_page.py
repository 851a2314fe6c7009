# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/reference/cpp.md: what the public headers declare, with their comments.

    python3 packaging/site/cpp_page.py FILE     writes the page
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
HEADERS = ROOT / "native" / "include" / "meanvalue"

#: The public headers, then what they include.
PUBLIC = (
    "deform/deformer.h",
    "sequence/sequence.h",
    "morph/morpher.h",
    "sliders/slider_fit.h",
    "common/execution.h",
    "common/errors.h",
    "deform/binding.h",
    "mesh/component.h",
    "common/shared_arrays.h",
    "common/types.h",
)

HEAD = """# C++ library

<!-- Written by `./dev docs reference` from the headers; a test compares. Do not edit. -->

The [jobs](jobs/one_pose.md) show it at work, and one page is for who comes
[from libigl, CGAL or Open3D](jobs/from_libigl.md). `meanvalue/meanvalue.h` includes all of it: `Deformer`, `deform()`,
`solve_sequence()`, `Morpher`, `SliderFit`, `Execution` and the exceptions, and what stands in their signatures. All is
in the namespace `meanvalue`. Private members are left out here.

## Build and install

In the repository, on Debian 12 after `apt-get install cmake g++ libeigen3-dev libopenmesh-dev`:

```sh
cmake -S . -B build/library -DMEANVALUE_BUILD_TESTS=OFF -DMEANVALUE_BUILD_PYTHON=OFF
cmake --build build/library -j 4
cmake --install build/library --prefix DIR
```

The build takes four minutes of one processor. In your project, with `cmake -DCMAKE_PREFIX_PATH=DIR`:

```cmake
find_package(meanvalue REQUIRED)
target_link_libraries(your_program PRIVATE meanvalue::meanvalue)
```

Without installing, the library becomes a part of your project: `add_subdirectory(FOLDER meanvalue EXCLUDE_FROM_ALL)` of
a copy of the repository, or `FetchContent`, in place of `find_package`. Tests and Python are off there. CMake must be
3.25 or later, the compiler GCC 9 or Clang 10 or later, in C++17. With `BUILD_SHARED_LIBS` the library is a shared one;
`MEANVALUE_OPENMESH_SOURCE` names OpenMesh's sources, for where it is not installed.
"""


def page():
    parts = [HEAD]
    for name in PUBLIC:
        source = (HEADERS / name).read_text()
        about = " ".join(re.match(r"((?://.*\n)*)", source)[1].replace("//", "").split())
        parts.append(f"## `meanvalue/{name}`\n\n{about}\n")
        for title, comment, code in declarations(source):
            parts += [f"### {title}\n", *([f"{comment}\n"] if comment else []), f"```cpp\n{code}\n```\n"]
    return "\n".join(parts).rstrip() + "\n"


def declarations(source):
    """[(name, comment as Markdown, code)] of what stands in the namespace and has a comment or is a type."""
    inside = source.partition("namespace meanvalue {\n")[2].partition("}  // namespace meanvalue")[0]
    chunk, depth = [], 0
    for line in inside.splitlines():
        if not chunk and not line.strip():
            continue
        chunk.append(line)
        depth += line.count("{") - line.count("}") + line.count("(") - line.count(")")
        is_comment = line.lstrip().startswith("//")
        if depth == 0 and not is_comment and line.rstrip().endswith((";", "}")):
            declared = _declaration(chunk)
            if declared:
                yield declared
            chunk = []


def _declaration(lines):
    comments = [line for line in lines if line.startswith("//")]
    code = [line for line in lines if not line.startswith("//")]
    text = "\n".join(code)
    named = re.search(r"^(?:enum class|class|struct)\s+(\w+)", text, re.M) or re.search(r"^using\s+(\w+)", text, re.M)
    if named is None:
        named = re.search(r"(\w+)\s*\(", text) or re.search(r"(\w+)\s*=", text)
    is_forward = re.fullmatch(r"(class|struct)\s+\w+;", text.strip())
    if named is None or is_forward:
        return None
    return named[1], comment_text(comments), _public(code)


def comment_text(lines):
    text = []
    for line in (line.lstrip("/ ").rstrip() for line in lines):
        tag = re.match(r"@(\w+)\s*(.*)", line)
        if tag:
            if text and not text[-1].startswith("* "):
                text.append("")
            text.append(f"* *{tag[1]}* {tag[2]}")
        else:
            text.append(f"  {line}" if text and text[-1].startswith(("* ", "  ")) and line else line)
    return "\n".join(text).replace("<", "&lt;").strip()


def _public(lines):
    """Without private sections and the bodies of functions."""
    kept, hidden_at = [], None
    for line in lines:
        indent = len(line) - len(line.lstrip())
        if re.match(r"\s*(private|protected):", line):
            hidden_at = indent
            continue
        is_public = re.match(r"\s*public:", line) and indent == hidden_at
        if hidden_at is not None and (is_public or (re.match(r"\s*}", line) and indent < hidden_at)):
            hidden_at = None
        if hidden_at is None:
            kept.append(line)
    text = re.sub(r"\n{2,}", "\n\n", "\n".join(kept)).strip()
    return re.sub(r"\n\n(\s*};)", r"\n\1", text)


if __name__ == "__main__":
    pathlib.Path(sys.argv[1]).write_text(page())
