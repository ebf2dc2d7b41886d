#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "daemon/store/store_impl.hpp"
#include "proto/text/digest.hpp"

namespace truepose::daemon {

using sqlite::in;
using sqlite::Statement;

namespace {

ModelRecord model_of(const Statement& row) {
  return {.id = row.text(0),
          .created = row.text(1),
          .campaign_id = row.text(2),
          .robot_serial = row.text(3),
          .yaml = row.document(4),
          .validation_before_mm = row.number(5),
          .validation_after_mm = row.number(6),
          .active = row.integer(7) != 0,
          .largest_correction_deg = row.number(8),
          .sha256 = row.text(9)};
}

}  // namespace

Statement Store::Impl::inserted(const ModelRecord& m) {
  Statement insert = database->prepare(
      "INSERT INTO model SELECT ?,?,?,?,?,?,?,0,?,? "
      "WHERE NOT EXISTS (SELECT 1 FROM model WHERE id=?1 AND sha256=?9)");
  insert.bind(m.id).bind(m.created).bind(m.campaign_id).bind(m.robot_serial).bind(m.yaml);
  insert.bind(m.validation_before_mm).bind(m.validation_after_mm);
  insert.bind(m.largest_correction_deg).bind(text::sha256_hex(m.yaml));
  return insert;
}

Statement Store::Impl::activated(const std::string& id) {
  Statement update = database->prepare("UPDATE model SET active=1 WHERE id=?");
  update.bind(id);
  return update;
}

Statement Store::Impl::none_active() { return database->prepare("UPDATE model SET active=0 WHERE active=1"); }

StoreResult<void> Store::add_model(const ModelRecord& m) {
  Statement insert = impl_->inserted(m);
  return impl_->commit("storing model " + m.id, {&insert});
}

StoreResult<void> Store::activate_model(const std::string& id) {
  const std::string operation = id.empty() ? "deactivating the model" : "activating model " + id;
  if (!id.empty()) {
    const StoreResult<std::optional<ModelRecord>> known = model(id);
    if (!known) return std::unexpected(in(operation, known.error()));
    if (!*known) return std::unexpected(in(operation, {"there is no such model"}));
  }
  Statement none = impl_->none_active(), one = impl_->activated(id);
  return impl_->commit(operation, {&none, &one});
}

StoreResult<std::vector<ModelRecord>> Store::models() {
  return all_records<ModelRecord>(
      impl_->database->prepare(
          "SELECT id, created, campaign_id, robot_serial, '', "
          "validation_before_mm, validation_after_mm, active, largest_correction_deg, sha256"
          " FROM model ORDER BY rowid DESC"),
      model_of);
}

StoreResult<std::optional<ModelRecord>> Store::model(const std::string& id) {
  Statement query = impl_->database->prepare("SELECT * FROM model WHERE id=?");
  query.bind(id);
  return first_record<ModelRecord>(std::move(query), model_of);
}

StoreResult<std::optional<ModelRecord>> Store::active_model() {
  return first_record<ModelRecord>(impl_->database->prepare("SELECT * FROM model WHERE active=1"), model_of);
}

StoreResult<std::optional<ModelRecord>> Store::model_before() {
  return first_record<ModelRecord>(
      impl_->database->prepare("SELECT model.* FROM activation JOIN model ON model.id=activation.model_id "
                               "WHERE model.active=0 ORDER BY activation.number DESC LIMIT 1"),
      model_of);
}

}  // namespace truepose::daemon
