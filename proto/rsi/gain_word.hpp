#pragma once

#include <cstdint>
#include <optional>

namespace truepose::rsi {

/// What Tp.Gain carries to $SEN_PINT[2]: how far the correction is ramped in, percent, or below 0 why there
/// is none, and a count that is another one in every cycle. By that a program sees that the PC still answers
/// and RSI still runs (truepose_stream.src, TP_GAIN), whatever the controller does with a word that stays.
///
/// -(1000 * count + 100 - gain), count from 1.
///
/// @param gain  -99 to 100
/// @param ipoc  of the packet that is answered
std::int64_t gain_word(std::int64_t gain, std::uint64_t ipoc);

/// @return  nothing where the word is none of these
std::optional<std::int64_t> gain_of(std::int64_t word);

}  // namespace truepose::rsi
