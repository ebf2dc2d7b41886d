#pragma once

#include <expected>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "core/quality/iso9283.hpp"

namespace truepose {

/// Brings poses as they were measured into the frame of the commanded ones, or says why it cannot.
using IntoCommandedFrame =
    std::function<std::expected<std::vector<TestPoint>, std::string>(std::vector<TestPoint>)>;

/// Why attained poses cannot be those that were commanded, one clause; nothing where they can. A mean
/// position farther from its commanded one than any arm errs is a mistake in the files: wrong units or
/// columns if their fix brings all positions near, else the farthest position and its distance.
///
/// @param points  as measured, each with an attained pose
std::optional<std::string> not_as_commanded(const std::vector<TestPoint>& points,
                                            const IntoCommandedFrame& into_frame);

}  // namespace truepose
