# SPDX-License-Identifier: GPL-3.0-or-later
"""docs/reference/jobs/: a page for each job that the library does, of the examples in both languages.

    PYTHONPATH=build/python python3 packaging/site/jobs_page.py FOLDER     writes the pages and their pictures

Text is what an example begins with, that of C++ above both, that of Python above its own; a picture shows the meshes
that the one in Python leaves in `U` or `half`.
"""

import pathlib
import re
import runpy
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
EXAMPLES = ROOT / "native" / "examples"
#: In the order of the menu.
NAMES = ("one_pose", "drag", "clip", "morph", "sliders", "from_libigl")

PAGE = """# {title}

<!-- Written by `./dev docs reference` from native/examples/; a test compares. Do not edit. -->

{text}

![The bar before and after]({name}.png)

## C++

```cmake
find_package(meanvalue REQUIRED) # or add_subdirectory(FOLDER meanvalue EXCLUDE_FROM_ALL)
target_link_libraries(your_program PRIVATE meanvalue::meanvalue)
```

How to build and install it: [four commands](../cpp.md#build-and-install).

```cpp
{cpp}
```

## Python

`pip install .` in the repository, [with what it needs](../../installing.md#the-python-module).

{notes}```python
{python}
```

The tests run both, in `native/examples/{name}.cpp` and `.py`; `bar.h` and `bar.py` beside them make the mesh.
Reference: [C++](../cpp.md), [Python](../python.md).
"""


def pages():
    """{name: text}"""
    found = {}
    for name in NAMES:
        source = (EXAMPLES / f"{name}.cpp").read_text(encoding="utf-8")
        head = re.match(r"(//.*\n)+", source)[0]
        title, _, text = re.sub(r"(?m)^// ?", "", head).partition("\n")[2].strip().partition("\n")
        python = (EXAMPLES / f"{name}.py").read_text(encoding="utf-8").partition("\n")[2]
        notes = re.match(r"(#.*\n)*", python)[0]
        found[name] = PAGE.format(
            title=title,
            text=text.strip(),
            name=name,
            cpp=source[len(head) :].strip(),
            notes=re.sub(r"(?m)^# ?", "", notes) + "\n" * bool(notes),
            python=python[len(notes) :].strip(),
        )
    return found


def picture(name, path):
    """Draws the mesh of an example before, pale, and after, seen from the front and a little from above."""
    import numpy as np
    from PIL import Image, ImageDraw

    sys.path.insert(0, str(EXAMPLES))
    left = runpy.run_path(str(EXAMPLES / f"{name}.py"))
    after = left.get("U", left.get("half", left.get("mixed")))
    shapes = [(left["V"], (200, 208, 216)), (np.asarray(after, float), (74, 127, 181))]
    if "bent" in left:
        shapes.insert(1, (left["bent"], (200, 208, 216)))
    view = np.array([[1.0, 0.0, 0.0], [0.0, 0.35, 0.94], [0.0, -0.94, 0.35]])  # right, up, towards the eye
    seen = [(shape @ view.T, color) for shape, color in shapes]
    corners = np.concatenate([shape[:, :2] for shape, _ in seen])
    low, high = corners.min(axis=0) - 0.2, corners.max(axis=0) + 0.2
    scale = 1440 / (high - low)[0]
    image = Image.new("RGB", (1440, int(scale * (high - low)[1])), "white")
    draw = ImageDraw.Draw(image)
    for shape, color in seen:
        triangles = shape[left["F"]]
        normals = np.cross(triangles[:, 1] - triangles[:, 0], triangles[:, 2] - triangles[:, 0])
        light = np.abs(normals @ [0.3, 0.5, 0.8]) / np.linalg.norm(normals, axis=1)
        for k in np.argsort(triangles[:, :, 2].mean(axis=1)):
            flat = (triangles[k, :, :2] - low) * [scale, -scale] + [0, image.height]
            shade = tuple(int(part * (0.6 + 0.4 * light[k])) for part in color)
            draw.polygon([tuple(point) for point in flat], fill=shade, outline=tuple(int(0.85 * s) for s in shade))
    image.resize((720, image.height // 2), Image.LANCZOS).quantize(64).save(path, optimize=True)


if __name__ == "__main__":
    folder = pathlib.Path(sys.argv[1])
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in pages().items():
        (folder / f"{name}.md").write_text(text, encoding="utf-8")
        picture(name, folder / f"{name}.png")
