#include "report/words/warning_table.h"

namespace sixdial::report {
namespace {

constexpr WarningWords kWords[] = {
    {"set_not_used",
     "{rows:row|rows} of {samples} {rows|belongs|belong} to the set \"{set}\" and "
     "{rows|is|are} not used: only G1 is fitted and only G2 validates.[ Was \"{meant}\" "
     "meant?]"},
    {"set_with_blanks",
     "{rows:row has|rows have} blanks around the name of the set, which nobody sees: it is "
     "read as \"{set}\"."},
    {"wrong_date",
     "{rows:row is|rows are} dated {date}, while the others begin at {others}: the time "
     "between the neighbours is taken instead."},
    {"clock_set_back",
     "The clock went back by {set_back} while this was measured. The rows are taken in the "
     "order in which they stand, and the time is taken to run on: do not sort them by time."},
    {"not_in_order_of_time",
     "The rows do not stand in the order of their times ({rows:step|steps} back): the times "
     "are believed, the order is not taken for that of measuring."},
    {"same_time",
     "All rows carry the same time: it does not say when each was measured, and is taken as "
     "not recorded."},
    {"long_pause",
     "{days:day|days} lie between this row and the one above: two sessions in one file, or a "
     "clock that was set. What changes with time is judged over the whole of it."},
    {"no_temperature",
     "All rows have a temperature of {value:g} degC, as thermometers say that are not there: "
     "taken as not recorded."},
    {"temperature_unit",
     "Temperatures are near {value:.2f}: that is {unit}, not degC. They are read as such "
     "({read_as:.2f} degC)."},
    {"wrong_temperature",
     "{rows:row has|rows have} a temperature of {value:g} degC, while the others are near "
     "{usual:.2f}: that of the neighbours is taken instead."},
    {"reading_for_none",
     "Dial {dial} reads {value:g} in {rows:row|rows} of {readings}, outside its travel of "
     "{travel:g} mm: an instrument's way to write that there is no reading. They are not "
     "used."},
    {"sign_of_dial",
     "Readings of {dials} are below zero, {below} of {readings}, which no dial of the rig file "
     "shows: their sign is the other way round. They are not used. Turn the sign in the data, "
     "or set {dials} to count up when the plunger is pushed in."},
    {"outside_travel",
     "Dial {dial} reads outside its travel of {travel:g} mm in {rows:row|rows} of {readings} "
     "({value:g}): look at its unit, its zero and travel_mm. They are not used."},
    {"end_of_travel",
     "Dial {dial} is pushed to the end of its travel of {travel:g} mm in {rows:row|rows}: it "
     "says nothing more of the tool there, and may be bent. They are not used. Keep the robot "
     "away from there."},
    {"dial_changed",
     "{dials} {reads} otherwise from {from} to {to}, {readings:reading|readings}[, {shift}]: a "
     "zero, a unit, a plug or a place changed while this was measured. Measure again, or make "
     "two sessions of it."},
    {"frame_moved",
     "From this row on the positions are shifted by {shift}: the instrument, its target or the "
     "robot's base was moved while this was measured. Measure again, or make two sessions of "
     "it."},
    {"far_position",
     "{rows:row has|rows have} a position {apart:.3g} from the middle of all, where "
     "{usual:.3g} is usual: a slip, or an instrument's way to write that there is none. Not "
     "used."},
    {"few_validating",
     "G2 has {samples:sample|samples}: too few to say how large errors are at other poses. "
     "Measure ten or more."},
    {"g2_at_poses_of_g1",
     "{rows:row|rows} of {validating} of G2 {rows|stands|stand} at {rows|a pose|poses} that "
     "{rows|was|were} fitted in G1: {rows|it shows|they show} how well the robot repeats, not "
     "how large errors are elsewhere."},
    {"copied_rows",
     "{rows:row repeats|rows repeat} another to the last digit, joint values and all readings: "
     "copied, or handed over twice. Each is counted once."},
    {"copied_repeats",
     "{rows:repeated reading equals|repeated readings equal} an earlier one of the same point "
     "to the last digit: copied, or the dials are too coarse to show any noise. Each is "
     "counted once, and the noise is not taken to be smaller than the resolution."},
    {"stuck_column",
     "Dial {dial} reads {value:g} mm in all of its {rows:row|rows}, wherever the tool is: it "
     "does not follow, or the column holds no readings. They are not used. Look at its plunger "
     "and its cable."},
    {"copied_columns",
     "Dials {dials} read the same to the last digit in {rows:row|rows}: a column was copied, "
     "or both names lead to one dial. Neither is used."},
    {"silent_dial",
     "No row has a reading of {dials}: not touched all the while, or not recorded."},
    {"resolution",
     "The readings of {dials} come in steps of {seen:g} mm, where the rig file states a "
     "resolution of {stated:g} mm: {seen:g} mm is used."},
    {"g2_repeats_g1",
     "{rows:row of G2 repeats a row|rows of G2 repeat rows} of G1 to the last digit and "
     "{rows|validates|validate} nothing: {left} of {validating} validation rows are left."},
    {"row_in_degrees",
     "{rows:row gives|rows give} the joint angles in degrees ({value:g}) where radians are "
     "expected: not used."},
    {"joint_wrapped",
     "{joint} jumps by whole turns in {rows:row|rows}: taken as one continuous angle."},
    {"joints_in_degrees",
     "The joint angles look like degrees: as such they put the nominal robot within {miss:.2g} "
     "mm of where it was measured. Give them in radians."},
    {"joint_unit",
     "The values of {joints} look like {unit}: as such they put the nominal robot within "
     "{miss:.2g} mm of where it was measured[, as they are within {now:.2g} mm]. Give them in "
     "radians."},
    {"joints_of_other_row",
     "The joint values look like those of {whose}: a row further on they put the nominal robot "
     "within {miss:.2g} mm of where it was measured[, as they stand within {now:.2g} mm]. They "
     "are taken so below. Look at what writes the file."},
    {"joints_exchanged",
     "{joints} look exchanged: the other way round they put the nominal robot within "
     "{miss:.2g} mm of where it was measured[, as they are within {now:.2g} mm]. Exchange the "
     "columns."},
    {"joint_reversed",
     "{joints} seems to turn the other way: with its sign changed the nominal robot is within "
     "{miss:.2g} mm of where it was measured[, as it is within {now:.2g} mm]. Change the sign "
     "of the column."},
    {"joints_echo_command",
     "The joint values that were read back equal those commanded to the last digit: this "
     "controller seems to give back what it was told. They do not say where the joints stood."},
    {"commanded_joints_fit_better",
     "The commanded joint values say better where the robot stood than those read back: fitted "
     "to half of the poses they leave {commanded:.3g} mm at the others, those read back "
     "{read:.3g} mm ({nearer} of {poses} poses are nearer). They are taken below. Look at "
     "encoders, couplings and at when the values are read."},
    {"read_joints_fit_better",
     "The joint values read back say better where the robot stood than those commanded: fitted "
     "to half of the poses they leave {read:.3g} mm at the others, those commanded "
     "{commanded:.3g} mm. They are taken; the robot does not stop where it is told."},
    {"commanded_joints_alike",
     "Commanded joint values and those read back say equally well where the robot stood "
     "({commanded:.3g} and {read:.3g} mm are left at poses that were not fitted). Those read "
     "back are taken."},
    {"few_poses_for_commands",
     "Joint values were commanded and read back, but there are too few poses to tell which of "
     "them say where the robot stood. Those read back are taken."},
    {"dials_exchanged",
     "Dials {dials} look exchanged ({how}): so they fit a robot like the rig file's within "
     "{miss:.2g} mm, as they are within {now:.2g} mm. A fit takes them put right. Exchange the "
     "columns, the plugs or the connections in the rig file."},
    {"dial_unit",
     "The readings of {dials} look like {unit}, scale {scale_in_words}: times {factor:g} they "
     "fit a robot like the rig file's within {miss:.2g} mm, as they are within {now:.2g} mm. "
     "They are taken times {factor:g} below; set the dial, or the data, to millimetres."},
    {"dial_reversed",
     "The readings of {dials} fall where they should rise: counted the other way they fit a "
     "robot like the rig file's within {miss:.2g} mm, as they are within {now:.2g} mm. They "
     "are turned round below; set the dial to count up when it is pushed in."},
    {"position_unit",
     "The measured positions ({columns}) look like {unit}: times {factor:g} they fit the "
     "nominal robot. They are taken times {factor:g} below; give them in millimetres."},
    {"position_scale",
     "The measured positions ({columns}) are {scale:.3g} times the size that the joint angles "
     "give the nominal robot: another unit, or other links than the rig file's."},
    {"columns_exchanged",
     "{columns} of the measured positions look exchanged: the other way round they fit the "
     "nominal robot within {miss:.2g} mm, as they are within {now:.2g} mm. They are exchanged "
     "below. Exchange the columns, or, if the instrument's frame is left-handed, turn one of "
     "its axes round."},
    {"axis_reversed",
     "{axis} of the measured positions points the other way: with its sign changed they fit "
     "the nominal robot within {miss:.2g} mm, as they are within {now:.2g} mm. It is changed "
     "below. The instrument's frame is left-handed: turn the axis round."},
    {"frame_mirrored",
     "The measured positions are in a left-handed frame: mirrored they fit the nominal robot "
     "within {miss:.2g} mm, as they are within {now:.2g} mm. They are mirrored below. Exchange "
     "two of its axes or turn one round."},
    {"frame_registered",
     "The positions were measured in a frame of the instrument's own, turned by {turn:.2f} deg "
     "and shifted by {shift:.1f} mm (at the middle of the work) against the rig file's. It was "
     "registered first[: {base} and all results are in that frame]; targets are meant in the "
     "rig file's frame and brought over."},
    {"base_registered",
     "The robot's base stands elsewhere than in the rig file: where it was measured the "
     "nominal robot is turned by {turn:.2f} deg and shifted by {shift:.1f} mm ({base}). The "
     "fit starts from there."},
    {"tool_turn_registered",
     "The tool's frame, as it was measured, is turned by {turn:.2f} deg on the last link "
     "against the rig file's; half of the turns fit the nominal robot within {left:.2g} deg "
     "then. The fit starts from there."},
    {"tool_turn_not_set",
     "The tool's frame, as it was measured, is turned by {turn:.2f} deg on the last link "
     "against the rig file's, and the robot's parameters cannot be set to that from where they "
     "are. The fit starts at the rig file's: turn the tool there (robot in rig.toml) about as "
     "the probe or the board sits."},
    {"turns_fit_nowhere",
     "The measured turns of the tool do not fit the nominal robot, however its frame sits on "
     "the last link: half of them are off by {left:.1f} deg or more. They are not used.[ Read "
     "as \"{better}\" they do: write orientation = \"{better}\" under instrument in rig.toml.] "
     "orientation = \"{orientation}\" is what the three angles are taken for now; they are "
     "those of the tool's frame in the instrument's, in the unit of the column's name."},
    {"far_turn",
     "{rows:turn|turns} of the tool {rows|is|are} off by more than {most:.1f} deg, unlike all "
     "others: not used."},
    {"far_turns",
     "{rows:turn|turns} of the tool {rows|is|are} off by more than {most:.1f} deg, unlike the "
     "others: too many of them, or too few would be left, to leave them out, so they are used. "
     "The probe was moved on the flange, or the angles of these rows mean something else."},
    {"few_turns",
     "Only {rows:turn|turns} of the tool {rows|was|were} measured: too few to see how its "
     "frame sits on the last link. Not used."},
    {"slipped_turn",
     "{rows:turn|turns} of the tool in G1 {rows|is|are} off by up to {most:.2g} deg from the "
     "robot that all others agree on, where {usual:.2g} deg is usual: not used."},
    {"slipped_turns",
     "{rows:turn|turns} of the tool in G1 {rows|is|are} off by up to {most:.2g} deg from the "
     "robot that the others agree on, where {usual:.2g} deg is usual: too many of them, or "
     "too few would be left, to leave them out, so they are used. The probe was moved on the "
     "flange, or the angles of these rows mean something else."},
    {"turns_not_explained",
     "The turn of the tool was measured, but no parameter of this robot follows it: it is not "
     "used. An arm needs tool = \"frame\" under robot in rig.toml."},
    {"sides_reversed",
     "In {rows:row|rows} the column says that joint {joint:g} came from the side that it moved "
     "away from: its sign is the other way round, and is taken so here. +1 is a joint that was "
     "turning up."},
    {"samples_drawn",
     "Causes were looked for in {drawn:.0f} of {samples:.0f} samples, drawn evenly over the "
     "session, and gross readings are listed of these only: enough to see what is there, and "
     "quick. \"sixdial diagnose SESSION --samples 0\" uses all."},
    {"sides_from_rows",
     "Nobody recorded from which side {joints} came: each move is taken to be the way from the "
     "row before."},
    {"targets_elsewhere",
     "{rows:target|targets} of {targets} {rows|lies|lie} {miss:.1f} mm from where the joint "
     "angles put the nominal robot: not used, and errors before the calibration are those of "
     "the nominal robot."},
    {"certificate_expired",
     "The certificate of {which} had run out (due {due} at the earliest) when this was "
     "measured on {measured}: its figures are not traceable until it is calibrated again."},
    {"wrong_mode",
     "All {samples} samples stand in working mode {mode}, the rig file says {rig_mode}: mode "
     "{mode} is used here. Correct the rig file, or the robot is commanded the other way "
     "round."},
    {"wrong_assembly",
     "All {samples} samples have the distal links closed the other way than the rig file says "
     "(assembly {assembly}, not {rig_assembly}): {assembly} is used here. Correct the rig "
     "file."},
    {"row_elsewhere",
     "{rows:row has|rows have} joint values that put the tool {apart:.1f} mm from where its "
     "target and its readings have it: the joint values of the row are wrong, not its dials. "
     "Not used."},
    {"positions_and_dials_differ",
     "Positions and dials of the same samples are {apart:.3f} mm apart: they are not in the "
     "same frame, or one of them is wrong. All commands use {used}, which are nearer to the "
     "nominal robot, and not {not_used}."},
    {"reference_pose",
     "The readings have the cuboid turned by {turn:.1f} deg against the rig file at all poses: "
     "the reference pose ({x:g}, {y:g}) mm is not the one of this rig. Turned so, the readings "
     "are {after:.3f} mm from the nominal robot instead of {before:.3f} mm."},
    {"mount",
     "The cuboid does not turn as the rig file says: on another mount the readings are "
     "{after:.3f} mm from the nominal robot instead of {before:.3f} mm."},
    {"too_few_poses",
     "{samples:sample|samples} of G1 stand at {poses:pose|different poses}, which cannot "
     "determine {parameters} parameters: {needed} are needed at least. What a fit leaves over "
     "says nothing then, and no reading is judged."},
    {"smaller_fit",
     "These poses determine {fitted:parameter|parameters} with something to spare: sixdial "
     "calibrate SESSION --fix {fix} holds the others at nominal."},
    {"implausible_length",
     "{name}, the {meaning}, came out as {value:.3f} mm where the rig file says {nominal:.3f} "
     "mm: no such robot is made. Look at the units, the dials' order and the rig file."},
    {"fits_nowhere",
     "At half of the samples the best fit is still off by {times:.1f} times what plausible "
     "changes of all parameters could explain: these are not the data of a robot like the rig "
     "file's. Look at the joint values (unit, order, sign), at what was measured and at the "
     "rig file."},
    {"far_angle",
     "{name}, the {meaning}, came out as {value:.2f} deg where the rig file says {nominal:.2f} "
     "deg. Enter it in the rig file if it is right: nominal commands go by the file."},
    {"made_unjudged",
     "This {what} is of an earlier version, which did not look for what is listed here: "
     "nothing of it was left out or put right. Make it again."},
};

}  // namespace

std::span<const WarningWords> warning_table() { return kWords; }

}  // namespace sixdial::report
