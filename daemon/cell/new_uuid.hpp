#pragma once

#include <boost/uuid/random_generator.hpp>
#include <boost/uuid/uuid_io.hpp>
#include <string>

namespace truepose::daemon {

/// The name of a campaign or a model.
inline std::string new_uuid() { return boost::uuids::to_string(boost::uuids::random_generator{}()); }

}  // namespace truepose::daemon
