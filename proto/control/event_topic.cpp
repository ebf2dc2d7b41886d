#include "proto/control/event_topic.hpp"

namespace truepose::control {

std::string_view name(Topic topic) {
  switch (topic) {
    case Topic::Cell:
      return "cell";
    case Topic::Campaign:
      return "campaign";
    case Topic::Measurement:
      return "measurement";
    case Topic::Stream:
      return "stream";
    case Topic::Model:
      return "model";
    case Topic::Fault:
      return "fault";
    case Topic::Log:
      return "log";
  }
  return "log";
}

std::optional<Topic> topic_from_name(std::string_view wanted) {
  for (const Topic topic : kAllTopics)
    if (name(topic) == wanted) return topic;
  return std::nullopt;
}

}  // namespace truepose::control
