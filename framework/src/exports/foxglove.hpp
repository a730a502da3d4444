// Results for Foxglove: an MCAP file of its own message types where there is one, else of plain JSON.
//
//   /track           foxglove.SceneUpdate      once: the edges of the road in the frame "world"
//   /cars            foxglove.SceneUpdate      once: a box per car, in the car's own frame
//   /tf              foxglove.FrameTransform   every step of every car: from "world" to the frame named after its row
//   /<row>/pose      foxglove.PoseInFrame      every step
//   /<row>/step      gripline.Step             every step: every column of steps.csv (framework/doc/output.md)
//
// Times are seconds from the start of the runs.
#pragma once

#include <string>

#include "exports/runs.hpp"

namespace gripline::exports {

/// The file's bytes. Runs without a column of time or a pose have no messages that need it.
std::string foxglove_mcap(const Results& results);

}  // namespace gripline::exports
