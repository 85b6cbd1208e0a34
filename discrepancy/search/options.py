"""The few numbers that decide when an effect is named. Each says what it protects from."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOptions:
    """Decision limits of the search.

    Attributes:
        alarm: least fall of the held-out loss, in noise variances, for an effect to enter. A search tries about 80
            starts;
            the 99.9 % quantile of the largest of 80 chi-square numbers with three degrees of freedom is about 28.
        unsure: the alarm is so many times higher where no repeats or periods show the noise: a whitening filter that
            was fitted to the residual of the best candidate flatters it.
        per_parameter: further fall asked for each parameter of an effect (log of the number of independent samples).
        material_noise: least closed gap in units of the noise of one sample; below it nobody could see the effect.
        material_signal: the same in units of the output's standard deviation: no rigid-body model of sampled data is
            better than a few thousandths.
        first_part, later_part: least part of the remaining gap (rms) that an effect must close, in the first round and
            later. The largest of three equal effects closes 0.58 of it, of two 0.71.
        simpler: a law with more parameters must close more than the simpler one that it contains by this part of it.
        doubt: fall of the held-out loss within which rivals count as equivalent.
        most_effects: the search ends after so many.
        material_rms: least relative fall of the rms error. Used where noise is not known and model error stands for it
            (judging by torque), zero otherwise.
        form_error: part of all that has been closed that a further effect must close: no reduced model is exact.
        faint_form_error, whole_part: the same for one or two effects that close at least this part of what is left
            (rms).
        chaotic_form_error: part of all that has been closed that a free curve must close to cast doubt on a model with
            backlash, whose free run is chaotic.
        chaotic_part: the same for a further effect, which has to fall by the alarm and close half of what is left too.
        own_form_error: the same for a curve over a named effect's own variable, before its law is doubted.
        left_noise, left_signal, left_gap, chaotic_left_gap: least remainder that is called unknown though no curve
            explains it, in units of one sample's noise, of the output's standard deviation, and of the gap that the
            search began with.
        exchanges: whether each named effect competes again with the catalogue once nothing more is added.
        finalists: candidates that are fitted again with the winner's noise model.
    """

    alarm: float = 30.0
    unsure: float = 3.0
    per_parameter: float = 8.0
    material_noise: float = 0.08
    material_signal: float = 0.003
    first_part: float = 0.3
    later_part: float = 0.5
    simpler: float = 0.02
    doubt: float = 12.0
    most_effects: int = 5
    exchanges: bool = True
    finalists: int = 5
    material_rms: float = 0.0
    form_error: float = 0.02
    faint_form_error: float = 0.003
    whole_part: float = 0.95
    chaotic_form_error: float = 0.2
    chaotic_part: float = 0.05
    own_form_error: float = 0.06
    left_noise: float = 0.3
    left_signal: float = 0.03
    left_gap: float = 0.15
    chaotic_left_gap: float = 0.4
