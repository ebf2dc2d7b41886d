#pragma once

#include <string>
#include <string_view>

namespace truepose::xml {

/// Text for the inside of an element or an attribute's quotes, in XML and in HTML. Control characters, for
/// which XML has no place, not even escaped, become U+FFFD.
std::string escaped(std::string_view text);

}  // namespace truepose::xml
