#pragma once

#include <string>

#include "proto/record/io.hpp"

/// Incidents of a campaign, as documents and answers have them.
namespace truepose::record {

/// A pose that was planned and has no point.
struct SkippedPose {
  int pose = 0;  ///< its number in the campaign, from 1
  int attempts = 0;
  std::string reason;
};
inline void layout(Io& io, SkippedPose& x) {
  io.record("SkippedPose");
  io.about("Its number in the campaign, from 1, as in documents, files and messages")("pose", x.pose,
                                                                                      kNumber);
  io("attempts", x.attempts, kCount);
  io("reason", x.reason);
}

/// After which the campaign continued.
struct Interruption {
  std::string interrupted, resumed;  ///< RFC 3339
  std::string found;                 ///< what had become of the cell meanwhile, in words
};
inline void layout(Io& io, Interruption& x) {
  io.record("Interruption");
  io.about("When, as far as it is known").format("date-time")("interrupted", x.interrupted);
  io.about("When it resumed").format("date-time")("resumed", x.resumed);
  io.about("What had become of the cell meanwhile, in words")("found", x.found);
}

}  // namespace truepose::record
