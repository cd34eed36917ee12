"""What will run and why: the passes of a frame as data."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Step:
    """One pass of a plan.

    Parameters
    ----------
    name : str
        Name of the pass, which is also that of its files in passes/ and shaders/.
    reason : str
        Why the scene needs it, or why not.
    inputs, outputs : tuple of str
        Names of the textures that it reads and writes.
    """

    name: str
    reason: str
    inputs: tuple[str, ...] = ()
    outputs: tuple[str, ...] = ()


@dataclass(frozen=True)
class Plan:
    """The passes that run, in order, those that were left out, and what a budget for the quality chose."""

    steps: tuple[Step, ...]
    left_out: tuple[Step, ...] = ()
    budget: str = ""

    def __contains__(self, name) -> bool:
        return any(step.name == name for step in self.steps)

    def __str__(self) -> str:
        lines = [f"quality by {self.budget}"] if self.budget else []
        for number, step in enumerate(self.steps, 1):
            arrow = f"{', '.join(step.inputs) or '-'} -> {', '.join(step.outputs)}"
            lines.append(f"{number}. {step.name}: {arrow}\n   because {step.reason}")
        lines += [f"-  {step.name}: left out, {step.reason}" for step in self.left_out]
        return "\n".join(lines)

    def check_inputs(self, given) -> list[str]:
        """Return a message for every input that no earlier step writes and the caller does not give."""
        known, missing = set(given), []
        for step in self.steps:
            missing += [f"{step.name} needs {name}" for name in step.inputs if name not in known]
            known |= set(step.outputs)
        return missing
