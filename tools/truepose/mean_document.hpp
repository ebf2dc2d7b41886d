#pragma once

#include <boost/json/fwd.hpp>

namespace truepose::tools {

/// The mean of every number over documents of the same shape (objects of numbers and such objects).
///
/// @param documents  at least one
boost::json::value mean_document(const boost::json::array& documents);

}  // namespace truepose::tools
