#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace truepose::recording {

// Frames of one wire resemble each other. A difference makes one from the frame before, in steps of three
// numbers and bytes: so many taken from it, so many of it passed over, so many new ones that follow.

/// Appends what makes `now` of `before`.
void append_difference(std::string& out, std::string_view before, std::string_view now);

/// What a difference makes of `before`; nothing where it cannot be of it, or would be longer than `most`.
std::optional<std::string> apply_difference(std::string_view before, std::string_view difference,
                                            std::size_t most);

// Whole numbers, seven bits a byte, the least first; signed ones in turn: 0, -1, 1, -2.

void append_number(std::string& out, std::uint64_t number);
void append_signed(std::string& out, std::int64_t number);
/// Takes a number from the front of `bytes`; nothing where there is none.
std::optional<std::uint64_t> take_number(std::string_view& bytes);
std::optional<std::int64_t> take_signed(std::string_view& bytes);

}  // namespace truepose::recording
