#pragma once

#include "config/yaml_reader.hpp"

namespace truepose::config {

/// What a YAML or JSON document is made for.
enum class DocumentKind {
  Robot,
  Model,
  Tool,
  Base,
  Positioner,
  Cell,
  Scenario,
  OpwParameters,
  CalibrationDocument,
  FrameDocument,
  PlanDocument
};

/// Refuses a document of another kind, by what it is: a reader would name the first key that it does not
/// know. What is of no kind is the reader's to refuse.
///
/// Throws ConfigError.
void expect_kind(const YamlValue& document, DocumentKind asked);

}  // namespace truepose::config
