#pragma once

#include <vector>

#include "daemon/store/store_error.hpp"
#include "proto/control/audit_chain.hpp"

namespace truepose::daemon {

/// Who knows beside the audit trail where it once ended, so that one that is shorter, or another, is found:
/// the store. Used by the thread that the store belongs to.
class AuditWitness {
 public:
  virtual ~AuditWitness() = default;
  virtual StoreResult<void> keep_audit_head(const control::AuditHead& head) = 0;
  virtual StoreResult<std::vector<control::AuditHead>> audit_heads() = 0;  ///< in the order of their numbers
};

}  // namespace truepose::daemon
