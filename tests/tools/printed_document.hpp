#pragma once

#include <gtest/gtest.h>

#include <boost/json/value.hpp>
#include <stdexcept>
#include <string>

#include "proto/control/json_text.hpp"

namespace truepose {

/// The document that a command printed: a line, in the form in which all documents are written.
inline boost::json::value printed_document(const std::string& out) {
  const auto document = control::parse_json(out);
  if (!document) throw std::runtime_error(document.error() + " of " + out);
  EXPECT_EQ(out, control::json_text(*document) + '\n');
  return *document;
}

/// Why a command ended that was asked for JSON: the line on its standard error.
inline std::string error_message(const std::string& err) {
  return std::string{printed_document(err).at_pointer("/error/message").as_string()};
}

}  // namespace truepose
