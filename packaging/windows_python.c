/* SPDX-License-Identifier: GPL-3.0-or-later */
/* python.exe, for a folder that has Python's DLL and library: wheel_parts.unpack_windows(). */
#include <wchar.h>

int Py_Main(int count, wchar_t **words);

int wmain(int count, wchar_t **words) { return Py_Main(count, words); }
