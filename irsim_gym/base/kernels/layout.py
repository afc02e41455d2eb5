"""The code of a packed entry: a function that loads a kernel's arguments from memory, and calls it."""

WORLDS, COUNT = "w", "n"
"""Marks in a layout: these arguments are not in memory, but the address and the number of worlds of each call."""


def entry_code(name: str, kernel: str, types: list[str], layout: str) -> str:
    """Return a packed entry in LLVM's language, as text: building it with llvmlite's objects takes four times as long.

    Args:
        name: Its name.
        kernel: The name of the function that it calls.
        types: The types of the function's arguments; the first two are the places for its value and an exception.
        layout: A letter for each other argument.
    """
    lines = ["%value = alloca i64", "%error = alloca i64"]
    handed = [f"{types[0]} %value", f"{types[1]} %error"]
    for k, (kind, mark) in enumerate(zip(types[2:], layout, strict=True)):
        if mark == WORLDS:
            lines.append(f"%word{k} = inttoptr i64 %worlds to {kind}")
        elif mark != COUNT:
            lines.append(f"%at{k} = getelementptr i64, ptr %words, i64 {k}")
            # Numba passes a boolean as one byte, but in memory it takes a word like all others.
            if kind == "i8":
                lines += [f"%wide{k} = load i64, ptr %at{k}", f"%word{k} = trunc i64 %wide{k} to i8"]
            else:
                lines.append(f"%word{k} = load {kind}, ptr %at{k}")
        handed.append(f"{kind} %count" if mark == COUNT else f"{kind} %word{k}")
    lines.append(f'%status = call i32 @"{kernel}"({", ".join(handed)})')
    head = f'declare i32 @"{kernel}"({", ".join(types)})\ndefine i32 @{name}(ptr %words, i64 %worlds, i64 %count) {{'
    return "\n".join([head, *lines, "ret i32 %status", "}"])
