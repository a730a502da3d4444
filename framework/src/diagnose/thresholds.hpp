// Every threshold of the diagnosis: its unit, what a larger value trades for what where it does, and its source where
// it has one.
// What set each, and what was measured of it: framework/doc/thresholds.md.
//
// What counts as a jump of a command stands where it is used, in measured/log/log.cpp, which knows nothing of diagnose.
//
// Log evidence is the log likelihood less Schwarz's penalty, in natural units: 3 stand for odds of 20 to 1.
#pragma once

#include <cstddef>

namespace gripline::diagnose::thresholds {

// ---- Adding and keeping effects

/// Log evidence that one effect must bring over none. Larger: fewer false names, small effects missed.
inline constexpr double single_gain = 3.0;
/// Log evidence that an effect beside others must bring: there are dozens to choose from. Larger: fewer false second
/// names, small second effects missed.
inline constexpr double further_gain = 6.5;
/// The least share of what the effects found so far explain that a further one must bring, because the linearisation
/// along the nominal car's trajectory is good to such a share only. Larger: small effects beside huge ones are missed;
/// smaller: linearisation errors are named.
inline constexpr double further_share = 0.002;
/// That share along the trajectory smoothed with the found model, where only errors of integration are left.
inline constexpr double further_share_refined = 0.0001;
/// Effects in one model; a log that asks for more is called unknown. Larger: more imitations of what the catalogue
/// lacks, and more work.
inline constexpr std::size_t max_effects = 3;

/// Models extended at each size, and extensions fitted of each, of the null model and of the others. Larger:
/// combinations that hide each other are found more often, in proportionally more time.
inline constexpr std::size_t beam = 2, first_tries = 8, tries = 6;
/// A model further behind the best of its size than this share of what that one explains is not extended. Larger: more
/// work for models that rarely win.
inline constexpr double beam_range = 0.5;
/// Extensions fitted where one effect is exchanged or added once more. Larger: more work.
inline constexpr std::size_t late_tries = 3;
/// Log evidence that an exchange must bring: above rounding, so that exchanges end.
inline constexpr double exchange_gain = 1e-3;
/// Pairs fitted as pairs. Larger: more work.
inline constexpr std::size_t pair_tries = 3;
/// Work of a search for each minute of log, in units of Linearised::work times samples (no clock enters). Larger:
/// slower answers where the catalogue imitates what it does not hold.
inline constexpr double work_per_minute = 3e6;

/// A candidate whose predicted gain is below this share of the best one's is not fitted.
inline constexpr double least_share_of_best = 0.03;
/// Share of the required gain, and of the penalty of an effect with more than three parameters, that a predicted gain
/// must reach to be worth a fit: predictions are good to a factor of two, and low where process noise still holds what
/// is missing. Larger: faster, and missed effects.
inline constexpr double predicted_gain_share = 0.4, predicted_penalty_share = 0.5;
/// How far below its final log evidence an unfinished fit may lie: a constant, and a share of what it explains. Larger:
/// more fits are finished in vain; smaller: the best model may be dropped unfinished.
inline constexpr double unfinished_slack = 15.0, unfinished_share = 0.2;
/// Factor on both for a fit after its first iterations, which is judged from less.
inline constexpr double early_slack = 2.0;
/// Models fitted again along the found model's trajectory: within this log evidence of the best, at most so many.
/// Larger: more work; smaller: rivals missing from the confidence.
inline constexpr double refit_range = 15.0;
inline constexpr std::size_t refit_models = 6;
/// Squared correlation of two regressors, less than one by this, from which on two effects are synonyms. Above
/// rounding, far below what any log resolves.
inline constexpr double synonym_tolerance = 1e-10;

// ---- Confidence and sets that cannot be distinguished

/// Log evidence above which an effect needs not also help on hold-out data. Smaller: small true effects that rest there
/// are kept; more false names.
inline constexpr double ample_evidence = 15.0;
/// Log evidence by which the best model must lead to be named alone. Larger: more verdicts `indistinguishable`, fewer
/// wrong names.
inline constexpr double equal_evidence = 2.0;
/// Posterior probability that a set of indistinguishable models holds the truth. Larger: larger sets. From the
/// definition of the verdict (framework/doc/diagnose.md, "Verdicts").
inline constexpr double set_coverage = 0.98;
/// Rivals that the bootstrap compares: within this log evidence of the best, at most so many. Beyond, a model wins no
/// resampled log.
inline constexpr double rival_range = 40.0;
inline constexpr std::size_t max_rivals = 12;
/// Logs resampled. Larger: shares of wins to within 1 / (2 sqrt(draws)) (0.025) in proportionally more time.
inline constexpr int bootstrap_draws = 400;
/// Largest confidences: in any name; beside an unknown effect; in an effect of place on a log of fewer laps than
/// `laps_to_tell_place_from_time`, where a gust may pass for a bank. Smaller: fewer answers that may be relied on.
inline constexpr double most_confidence = 0.999, most_beside_unknown = 0.5, most_in_one_lap = 0.9;
inline constexpr double laps_to_tell_place_from_time = 2.0;

// ---- Hold-out

/// One part in this many of a log without hold-out logs is held out, in whole laps where it has that many. Larger: more
/// is left to fit, the gap is measured on less. From framework/doc/diagnose.md.
inline constexpr std::size_t hold_out_part = 3;
/// Largest ratio of 1 s errors on hold-out data, found over nominal model, that lets a well supported name stand.
/// Larger: names that predict worse are kept. framework/doc/diagnose-cases.md calls a result worse than nominal beyond
/// it.
inline constexpr double worse_on_hold_out = 1.02;
/// That ratio with strong process noise, most of whose errors no model removes.
inline constexpr double worse_with_process_noise = 1.1;
/// Share of that error that what is named must take off of too little held-out data for an interval, where delays were
/// taken off: what these are wrong by takes off less. Larger: short logs with late channels stay unknown.
inline constexpr double more_than_delays = 0.5;
/// Share of the 1 s error on hold-out data that named effects must close. Larger: small true effects are not named.
inline constexpr double least_closing = 0.001;
/// Share of the gap that effects named beside an unknown one must close to be kept.
inline constexpr double closure_beside_unknown = 0.5;

/// Time between the starts of predictions [s]. Smaller: errors of more starts, which overlap more, in proportionally
/// more time. From framework/doc/diagnose.md, "The gap".
inline constexpr double start_spacing = 0.5;
/// Starts of predictions that count as one piece of evidence (2 s: predictions of 1 s overlap); the least, where
/// hold-out data are short (1 s); and blocks of them below which their change has no interval.
inline constexpr std::size_t rollout_block = 4, short_rollout_block = 2, fewest_rollout_blocks = 4;

// ---- Tests that nothing is left

/// Errors of a channel over its stated noise, and their correlation from sample to sample, beyond which the channel is
/// said to be wrong: noise that is measured with the model takes them up. Larger: noise that is stated too small is no
/// alarm, errors of a sensor that no effect explains pass for noise.
inline constexpr double wrong_channel = 3.0, slow_colour = 0.8;
/// Errors 1 s ahead of a real log's quantity over the noise of its own sensors, beyond which more could be found.
/// Larger: a channel that is wrong is reported less often.
inline constexpr double far_above_noise = 3.0;

/// Standardised statistic of a test beyond which the model is rejected. Larger: fewer false alarms, weaker deviations
/// missed. 4 standard deviations of the joint tests' chi-square are about one chance in thousands.
inline constexpr double misfit = 4.0;
/// `misfit` where commands are uncertain by what is counted as normal noise and is not: the world holds them in steps
/// of which the log left some out, and they jump; or they were rounded in steps that move the car. Larger: fewer true
/// effects beside something unknown, weaker deviations missed.
inline constexpr double misfit_uncertain_commands = 8.0;
/// Standard deviations of a normal that count as much as `misfit` in tests of few functions. Theirs is a cube root
/// approximation with lighter tails.
inline constexpr double misfit_focused = 3.5;
/// `misfit_focused` with process noise: regressors evaluated along a reference that carries the noise make the
/// statistic wider than its chi-square. Larger: fewer spectral lines found in process noise, weaker deviations missed.
inline constexpr double misfit_focused_process_noise = 7.0;
/// Share of its gain that a spectral line counts with, because its frequency was chosen; with strong process noise,
/// whose own spectrum it was chosen from, half of that. Larger: more false lines.
inline constexpr double line_share = 0.5, line_share_process_noise = 0.25;
/// Highest frequency of a spectral line [Hz]: faster accelerations hardly move a car. Larger: more work, more chances
/// of false lines.
inline constexpr double line_highest = 3.0;
/// Periodogram ordinates on either side that estimate the spectrum around a line, and those beside it left out. Larger:
/// steadier, but blurs a spectrum that changes.
inline constexpr std::ptrdiff_t line_background = 16, line_width = 3;
/// By how much log(1 / p) of a line must exceed the log of the number of ordinates before it is tested. Larger: faster;
/// weak lines missed.
inline constexpr double line_margin = 2.0;
/// Knots of the functions of place over a lap; spacing [s] of those of time, at least 4 and at most 40 of them. More:
/// finer places, weaker tests.
inline constexpr std::size_t place_knots = 24;
inline constexpr double time_spacing = 2.0, least_time_knots = 4.0, most_time_knots = 40.0;
/// The strongest knot's gain over that which its neighbours need to belong to the interval reported. Larger: wider
/// intervals.
inline constexpr double interval_ratio = 3.0;

// ---- Process noise

/// Typical size of unknown accelerations [m/s2]; of yaw that over the wheelbase [rad/s2]. From the process noise of
/// framework/doc/diagnose-cases.md. All ratios below are in this unit.
inline constexpr double typical_acceleration = 0.1;
/// Ratio that the first fit starts from.
inline constexpr double start_process_noise = 5.0;
/// Ratio to which process noise counts as zero: smaller ones move no reading.
inline constexpr double no_process_noise = 0.003;
/// Ratio from which on all three accelerations together count as strong process noise (a rough road). Larger: penalties
/// and tests for white noise are used where they do not hold.
inline constexpr double strong_process_noise = 0.2;
/// Ratio from which on noise in another acceleration makes a focused test strict, and from which on noise in some
/// accelerations only is tested; and the largest ratio over that below which another acceleration is calm.
inline constexpr double noticeable_process_noise = 0.1, uneven_ratio = 3.0;
/// Ratio below which process noise may be parameters still on their way to the optimum, and the factor on the least
/// variance from which on it is worth asking. Saves fits that would creep along a flat valley.
inline constexpr double may_vanish = 0.5, above_least = 4.0;

// ---- Noise that is measured

/// Lag-one correlation of innovations, in standard deviations of that of white ones, from which on the colour of the
/// sensors' noise is measured. Larger: faster; weak colours pass for white.
inline constexpr double coloured_innovations = 5.0;
/// Log likelihood that measured noise must bring to be accepted, or to stay so: before effects are searched, and after.
inline constexpr double noise_gain_before = 30.0, noise_gain = 10.0;
/// Standard deviations by which a colour must differ from white, its least and its largest size.
inline constexpr double significant_colour = 3.0, least_colour = 0.05, most_colour = 0.97;
/// Colour from which on noise of a sensor may be an offset, which hardly changes and an effect may explain [-]: noise
/// is then measured from white sensors too. Smaller: slower.
inline constexpr double offset_colour = 0.95;
/// What noise must differ by from what was assumed, to search again: the factor on a correlation time or a level, and
/// a colour. Less counts too where it brings `noise_gain_before`: differences of a tenth in all channels can be worth
/// hundreds of units, and are made up for by unknown accelerations that are not there.
inline constexpr double other_noise_factor = 1.25, other_colour = 0.1;
/// Factor on `coloured_innovations` before effects are searched for: effects that are missing colour the innovations
/// too. Less measures noise twice where an effect explains the colour.
inline constexpr double plainly_coloured = 2.5;
/// Least measured level of a sensor over the one assumed before, where that was coloured over the scatter from sample
/// to sample [-]. Smaller: where the model is far off, one channel may be taken for exact and all others for noise.
inline constexpr double least_level = 0.5;
/// Scatter from sample to sample that measured noise implies, over that seen [-], up to which it is accepted. Larger
/// takes an effect that is missing for noise.
inline constexpr double most_scatter = 1.7;
/// Range of the correlation time of unknown accelerations [s].
inline constexpr double shortest_noise_time = 0.02, longest_noise_time = 4.0;
/// What commands do half-way between samples that a log does not say, over the root mean square of their second
/// differences: the most, of commands that walk at random (the root of 1/8 is 0.35); the share of that at which
/// measuring begins; and the share at which it is none. Larger `most_command` takes effects that are missing for noise.
inline constexpr double most_command = 0.5, first_command = 0.5, least_command = 0.02;
/// Standard deviations of the score of unknown commands from which on they are measured. Where logs say all the score
/// is negative. Larger: faster; logs with little left out pass for whole.
inline constexpr double asks_for_commands = 1.0;
/// Factor on the least variance of an unknown acceleration (`no_process_noise`) [-] from which on it may be what
/// commands did between samples. Larger: faster; what was left out passes for other noise.
inline constexpr double may_be_left_out = 4.0;
/// Bend of commands between samples (-1/8 is a parabola) from which on it is an effect's, and what a bend must differ
/// by to search again.
inline constexpr double most_bend = 0.3, other_bend = 0.03;
/// Relative difference of two logs' rates up to which a bend measured in one is that of the other: an uneven recorder's
/// own rate varies by less. Larger: bends are assumed of logs that nobody measured them in.
inline constexpr double same_rate = 0.01;
/// Samples that noise is measured on; iterations, and log likelihood by which one must improve to go on.
inline constexpr std::size_t noise_samples = 3000;
inline constexpr int noise_iterations = 8;
inline constexpr double noise_converged = 0.3;

// ---- Delays of channels

/// Samples that a channel must at least be late by its estimate, and by the near end of its interval. Larger: shorter
/// delays pass for effects of the car; smaller: noise passes for a delay.
inline constexpr double least_delay = 1.0, least_delay_bound = 0.5;
/// Samples by which a delay of place or yaw that was taken off may at least still be wrong (a standard deviation; twice
/// it at most). Smaller: what is left of it passes for something unknown; larger: effects that move readings along the
/// way hide in it.
inline constexpr double left_of_delay = 0.25;
/// Standard deviation, in samples, of a delay by what readings do between samples: speeds are read as linear there, and
/// bend where held commands jump. Larger: wider intervals of delays.
inline constexpr double delay_between_samples = 0.05;
/// The longest delay of a place that a lever may stand for [s]. Larger: levers of metres on slow cars are tried as one.
inline constexpr double longest_late_place = 0.6;
/// Probability that the interval misses the delay: a delay is named in front of everything else, so that each of the
/// two groups of channels has half of the verdicts' false alarms (1 %). Larger: coloured noise passes for a delay.
inline constexpr double false_delay = 0.005;

// ---- Sensors

/// Noise seen over noise stated: within these the stated is used, else the seen.
inline constexpr double noise_agrees_from = 0.85, noise_agrees_to = 1.15;
/// White noise shows alike in differences of any order. Where eighth ones show less than this share of what fourth ones
/// do, the car moves quickly; what is then up to `hidden_by_motion` times the stated noise may be motion too: commands
/// held at the rate of the log shake a small car up to its highest frequency. Larger `noise_is_motion`: noise above the
/// stated passes for motion.
inline constexpr double noise_is_motion = 0.85, hidden_by_motion = 1.5;
/// Noise seen over noise stated below which a log is noise-free (simulated or filtered), and the share of the stated
/// that is then used.
inline constexpr double noise_free = 0.05;
/// Standard deviation of what rounding does to a reading, over that of its noise, from which on it counts: less adds
/// half a per cent to the noise.
inline constexpr double least_rounding = 0.1;
/// Least standard deviation of a sensor, in wheelbases, rad and v_ref: keeps the filter regular.
inline constexpr double least_sensor_noise = 1e-6;
/// Standard deviations of the speed sensors by which the state may jump where a command was not recorded. A quick move
/// of the steering for 20 ms is worth some twenty of a gyroscope's. Smaller: what was not recorded passes for an
/// effect.
inline constexpr double lost_command_jump = 20.0;
/// Standard deviations of a sensor in which the first state is unknown (diffuse start).
inline constexpr double diffuse_start = 300.0;

// ---- Priors and penalties

/// Nuisance parameters deviate by at most this many of their standard deviations: what is beyond is a missing effect.
/// From framework/doc/diagnose.md, "Parameters that are not known well": deviations are clipped there.
inline constexpr double nuisance_limit = 2.0;
/// Parameters of one effect that cost Schwarz's whole penalty, and the share that each further one (the shape of a
/// profile along the lap) costs. A chi-square of fixed significance grows by about one unit of log likelihood per
/// degree of freedom; two are charged. Smaller: false grades and banks; larger: true ones are missed in process noise.
/// Effects with more parameters than that also stay where they are while bends of commands are measured.
inline constexpr std::size_t full_penalty_parameters = 3;
inline constexpr double shape_penalty = 0.4;

// ---- Fits

/// Log likelihood that a fit may leave unfound: while models are chosen, and in the end.
inline constexpr double rough_tolerance = 0.05, fine_tolerance = 0.01;
/// Iterations of a first look, of finishing a promising fit, and of finishing it along the last reference.
inline constexpr int rough_iterations = 4, finish_iterations = 7, last_iterations = 12;
/// Iterations of the result's last fit, along the reference that it smooths itself.
inline constexpr int result_iterations = 5;
/// Iteration from which on a fit is tried without process noise: after a whole step, and after any.
inline constexpr int without_noise_from = 3, without_noise_at_last = 5;
/// Rise of the negative log likelihood that passes for rounding.
inline constexpr double cost_rounding = 1e-6;
/// Longest step of a parameter in its scales, per iteration; farther out the linearisation means nothing.
inline constexpr double longest_step = 30.0;
/// Longest step to a start value that a score test predicts, in the parameter's scales.
inline constexpr double longest_start = 20.0;
/// Factors on the step after one that did not improve: with the variances moved, with the parameters alone; growth of
/// the variances' step after success; the share of a step at which a fit gives up.
inline constexpr double shorter_noise_step = 0.25, shorter_step = 0.35, longer_noise_step = 3.0, shortest_step = 0.02;
/// Share of each parameter's own information that is added to it in a step back to the floor of a curved valley: far
/// above the weight of a prior among laps of data, far below what these determine.
inline constexpr double correction_damping = 1e-3;
/// Noise variances per iteration: least factor, largest step of the logarithm (a factor of thirty).
inline constexpr double least_noise_factor = 0.01, longest_log_noise_step = 3.4;
/// Predicted gain of the variances, in tolerances, that may be left: near their floor the prediction is too large.
inline constexpr double noise_tolerance = 5.0;
/// A fit that cannot reach what is wanted even if its next step gains this many times what is predicted is given up.
inline constexpr double reachable_factor = 4.0;
/// Root mean square move of a reference, in sensor standard deviations, below which it has converged (what is left is
/// of second order in it), and the largest number of iterations.
inline constexpr double reference_tolerance = 0.03;
inline constexpr int reference_iterations = 5;

// ---- Numerics

/// Least eigenvalue of an equilibrated information matrix that counts towards its rank: in fits, in score tests of many
/// directions, in screening of one direction (an effect that is a nuisance under another name differs only by the
/// nuisance's prior) and of several. Above rounding.
inline constexpr double rank_tolerance_fit = 1e-10, rank_tolerance_test = 1e-5, rank_tolerance_one = 1e-10,
                        rank_tolerance_several = 1e-6;
/// Step of integration over the car's time constant: an error of 0.3^5 / 120 of what settles within it. Steps per
/// sample at most.
inline constexpr double longest_integration_step = 0.3, most_substeps = 8.0;
/// Step of integration over the time constant of an effect's memory; of a stiff one, which settles within a sample from
/// `stiff` on, where the step must only be stable; stiffer than `stiffest` is integrated as that.
inline constexpr double longest_memory_step = 0.8, longest_stiff_step = 1.4, stiff = 4.0, stiffest = 20.0;

}  // namespace gripline::diagnose::thresholds
