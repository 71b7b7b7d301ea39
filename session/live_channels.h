// Dials that stand for channels of another instrument than the cuboid's: a draw wire with the
// interface of a dial is the distance from an anchor, a dial on a stand that a ball on the tool
// pushes in is the touch of a plane. In rig.toml a [[dial]] has the name of its [[anchor]] or
// [[surface]] as `id`.
//
//   distance_K1 =  reading of dial K1      (the wire's length)
//   probe_bed   = -reading of dial bed     (so far behind the plane of first contact)
//   x, y, z     =  where the lengths of four or more wires from known anchors meet ("position")
//
// Collected are the dials, as they read; studies, files and reports see the instrument. What it
// shows is made from what was read each time a session is taken out of the store.
#pragma once

#include <optional>
#include <string>

#include "session/sample_layout.h"
#include "session/session.h"

namespace sixdial::session {

/// The rig's dials are channels of its instrument, and no dials on a cuboid.
[[nodiscard]] bool has_live_channels(const geometry::Rig& rig);
/// ... and together they give positions: wires from anchors whose places are known.
[[nodiscard]] bool has_live_positions(const geometry::Rig& rig);
inline constexpr std::size_t kLeastWires = 4;

/// Why the dials of a rig cannot be the channels of its instrument: a name that no place has, a
/// place that no dial reads. Empty: they can, or the rig has no such dials.
[[nodiscard]] std::optional<std::string> live_channel_fault(const geometry::Rig& rig);

/// The rig as its instrument is: without the dials. Any other rig as it is.
[[nodiscard]] geometry::Rig as_instrument(geometry::Rig rig);
/// A sample of the dials as one of the instrument; `rig` has the dials. A bad reading is none.
[[nodiscard]] Sample as_instrument(const geometry::Rig& rig, Sample sample);
/// The way back: readings of the rig's dials that give the instrument's channels.
[[nodiscard]] Sample as_dials(const geometry::Rig& rig, Sample sample);
/// Rig and samples; the texts of its files stay.
[[nodiscard]] Session as_instrument(Session session);

}  // namespace sixdial::session
