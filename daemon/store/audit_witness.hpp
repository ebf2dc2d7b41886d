#pragma once

#include <vector>

#include "daemon/store/store_error.hpp"
#include "proto/control/audit_chain.hpp"

namespace truepose::daemon {

/// A second record of where the audit trail ended, so that a shorter or replaced trail is found. The store
/// keeps it. Used by the store's thread.
class AuditWitness {
 public:
  virtual ~AuditWitness() = default;
  virtual StoreResult<void> keep_audit_head(const control::AuditHead& head) = 0;
  virtual StoreResult<std::vector<control::AuditHead>> audit_heads() = 0;  ///< in the order of their numbers
};

}  // namespace truepose::daemon
