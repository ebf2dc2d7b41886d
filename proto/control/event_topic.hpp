#pragma once

#include <array>
#include <optional>
#include <string_view>

namespace truepose::control {

enum class Topic { Cell, Campaign, Measurement, Stream, Model, Fault, Log };

inline constexpr std::array kAllTopics{Topic::Cell,  Topic::Campaign, Topic::Measurement, Topic::Stream,
                                       Topic::Model, Topic::Fault,    Topic::Log};

/// Name on the wire: "campaign".
std::string_view name(Topic topic);
std::optional<Topic> topic_from_name(std::string_view name);

}  // namespace truepose::control
