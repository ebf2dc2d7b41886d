#pragma once

#include <optional>

#include "daemon/realtime/stream_status.hpp"

namespace truepose::daemon {

/// An axis that stands at a limit of the controller and is sent more. deg.
struct ClampedAxis {
  int axis = 1;
  double sent_deg = 0, stands_deg = 0;
};

/// Whether what the axes show is the correction clamped by AXISCORR, which does that silently: every axis has
/// what it is sent, or stands at a limit that those sent more in the same direction share. Of a single axis
/// that limit has to be a round number, as limits are typed.
///
/// @return the axis that lacks most; none where it is not that, or the measured correction is not known
std::optional<ClampedAxis> clamped_axis(const StreamStatus& status);

}  // namespace truepose::daemon
