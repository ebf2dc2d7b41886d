#pragma once

#include <boost/json/fwd.hpp>
#include <string_view>

namespace truepose::tools {

/// The mean of every number over documents of the same shape (objects of numbers and such objects).
///
/// @param documents  at least one
boost::json::value mean_document(const boost::json::array& documents);

/// How the errors of several validations differ: {"over","count","before","geometric","after"}, each stage
/// with the standard deviations of {"mean","max","rms"}, mm.
///
/// @param validations  "validate" of each run, at least two
/// @param over         what the runs are: "splits" or "folds"
boost::json::object spread_document(const boost::json::array& validations, std::string_view over);

}  // namespace truepose::tools
