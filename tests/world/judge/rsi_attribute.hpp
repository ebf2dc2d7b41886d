#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace truepose::world {

/// The number of an attribute in an RSI text, as of A1 in <AK A1="0.0123" .../>; none where it has none.
std::optional<double> rsi_attribute(std::string_view text, const std::string& element,
                                    const std::string& name);

}  // namespace truepose::world
