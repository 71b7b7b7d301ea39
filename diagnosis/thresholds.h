// The numbers that decide a verdict, in one place; those that the user may change are in
// NamingSettings (naming.h). They were chosen on simulated sessions of the blind challenge,
// whose hidden effects leave 0.1 to 5 times the noise (mock_devices/hidden/all_causes.cpp), so
// that the table of spec 4 is kept. Numbers of the arithmetic alone stand where they are used.
#pragma once

#include <cstddef>

namespace sixdial::diagnosis {

// ---- Gross readings.
/// A reading with less than even odds of being good is gross ...
inline constexpr double kGoodWeight = 0.5;
/// ... and is listed as such if it is that many standard deviations off as well: among some
/// thousand readings, four happen by chance.
inline constexpr double kGrossSigma = 5.0;
/// Gross errors are anywhere within this; a dial that loses its face is off by about as much.
inline constexpr double kGrossRange_mm = 1.0;
/// Share of gross readings: at least this, or a single one would pull the fit; at most this,
/// or the fit could explain half of a session and call the rest gross.
inline constexpr double kLeastGrossShare = 0.002;
inline constexpr double kMostGrossShare = 0.25;
/// Gross errors are single readings. A dial with a larger share of them is wrong as a whole.
inline constexpr double kMostGrossOfADial = 0.5;
/// A verdict that leaves out a larger share of the readings than this is never certain: what
/// was left out may say something else.
inline constexpr double kMostLeftOut = 0.08;
/// With more gross readings than this (single gross errors are fewer than one in twenty), a fit
/// may have settled on a part of the session: it is tried again from far away. The likelier of
/// the two counts, so that this decides time and no verdict.
inline constexpr double kSuspiciousGrossShare = 0.06;

// ---- A baseline that looks wrong as a whole: dials exchanged, tips off their faces.
/// Share of gross readings, and scatter in units of the rig file's noise. Single gross errors
/// are fewer than 4 %, and an effect leaves less than 8 times the noise; exchanged dials differ
/// by millimetres.
inline constexpr double kMuchGross = 0.04;
inline constexpr double kFarOff = 8.0;
/// Log odds that exchanged dials must show: more than any one gross reading costs, so that a
/// few of these never pass for an exchange.
inline constexpr double kExchangeLogOdds = 50.0;

// ---- Noise.
// Repeats tell it from calibration::kEnoughRepeats degrees of freedom on.
/// Scatter is more than the noise at this level of chance; against a rig file's figure, which
/// is a maker's word and not a measurement, it must be larger by this factor as well.
inline constexpr double kScatterLevel = 1e-3;
inline constexpr double kMakersWord = 1.3;
/// A dial scatters more than the others at this level, by at least this factor: less would not
/// change a verdict. Of six dials, 0.6 % of good sessions come so far by chance where a dial
/// has few readings; with 150 a dial the factor alone is passed by chance once in 1e5.
inline constexpr double kUnevenLevel = 1e-3;
inline constexpr double kUnevenFactor = 1.3;
inline constexpr double kFewestOfADial = 20.0;  // readings, less their share of the parameters

/// Log evidence that a shift which the readings of an arrival share must show before it counts
/// as noise: for its size, for being of the tool or of the joints, and as any finding must.
inline constexpr double kSharedLogOdds = 5.0;
/// Readings more than their samples' shifts take up, before such shifts can be asked for.
inline constexpr double kFewestOfScatter = 30.0;

// ---- Names.
/// If less than this share of an effect's signal is left once the fitted parameters have taken
/// over what they can, they absorb the effect: the rest is rounding.
inline constexpr double kLeastSurviving = 1e-5;
/// Sizes are believed by a Cauchy density of this width, in plausible sizes: a hundred times
/// what rigs of this kind show costs six units of log evidence, and is named if nothing else
/// says it.
inline constexpr double kBelievedWidth = 5.0;
/// How far below the best a candidate's linear score may be, and how many are then fitted: a
/// linear score misses the refitted evidence by a few units, and by more for large effects.
struct Shortlist {
  double within;  // log evidence
  std::size_t most;
};
inline constexpr Shortlist kNextNames{25.0, 8};
inline constexpr Shortlist kNextNamesAmongGross{25.0, 4};
inline constexpr Shortlist kNamesForUnknown{25.0, 5};
inline constexpr Shortlist kBetterRivals{15.0, 5};
inline constexpr Shortlist kTies{15.0, 6};
inline constexpr Shortlist kStandIns{15.0, 5};
/// Smooth functions whose linear scores differ by less are not told apart.
inline constexpr double kUnknownTie = 6.0;
/// A session needs so many readings beyond the number of parameters.
inline constexpr int kFewestToSpare = 10;
/// An effect that must be so many times its plausible size to be detected is not testable.
inline constexpr double kBelievableSizes = 5.0;

}  // namespace sixdial::diagnosis
