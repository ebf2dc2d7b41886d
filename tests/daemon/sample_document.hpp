#pragma once

#include <boost/json/object.hpp>

namespace truepose::report {

/// A calibration of a two-joint arm on seeded errors of the size that a real arm has: `points` to identify,
/// as many to validate, made by record::calibration_document.
boost::json::object sample_document(int points, bool validated);

/// The same with every optional member: re-measured points, stream, truth and who is who.
boost::json::object full_document(int points);

}  // namespace truepose::report
