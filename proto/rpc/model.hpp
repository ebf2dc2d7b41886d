#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/rpc/method.hpp"

namespace truepose::rpc {

struct ModelSummary {
  std::string id{};
  std::string created{};
  std::string campaign_id{};
  std::string robot_serial{};
  std::optional<double> validation_before_mm{};
  std::optional<double> validation_after_mm{};
  bool active = false;
  std::optional<std::string> warning{};
};
void layout(Io& io, ModelSummary& x);

struct Parameter {
  std::string name{};
  double nominal = 0;
  double value = 0;
  double sigma = 0;
  bool identified = false;
  std::optional<double> data_share{};
};
void layout(Io& io, Parameter& x);

/// model.list
struct ModelList {
  struct Result {
    std::vector<ModelSummary> models{};
    int total = 0;
  };
  static const Method& method();

  int limit = 20;
  std::uint64_t offset = 0;
};
void layout(Io& io, ModelList& x);
void layout(Io& io, ModelList::Result& x);

/// model.get
struct ModelGet {
  struct Result {
    ModelSummary model{};
    std::vector<Parameter> parameters{};
  };
  static const Method& method();

  std::optional<std::string> id{};
};
void layout(Io& io, ModelGet& x);
void layout(Io& io, ModelGet::Result& x);

/// model.activate
struct ModelActivate {
  using Result = ModelSummary;
  static const Method& method();

  std::string id{};
};
void layout(Io& io, ModelActivate& x);

/// model.rollback
struct ModelRollback : NoParameters {
  using Result = ModelSummary;
  static const Method& method();
};

/// model.deactivate
struct ModelDeactivate : NoParameters {
  struct Result {
    std::optional<std::string> deactivated{};
  };
  static const Method& method();
};
void layout(Io& io, ModelDeactivate::Result& x);

/// model.export
struct ModelExport {
  struct Result {
    std::string id{};
    std::string yaml{};
  };
  static const Method& method();

  std::optional<std::string> id{};
};
void layout(Io& io, ModelExport& x);
void layout(Io& io, ModelExport::Result& x);

/// The methods of this file.
std::vector<Described> model_methods();

}  // namespace truepose::rpc
