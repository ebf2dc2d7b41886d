#pragma once

#include "daemon/campaign/measuring_session.hpp"

namespace truepose::daemon {

/// Measures the nests, and two poses that were measured before the interruption, far from each other. Where
/// these are not where they were, more of them are measured, and show by how much tracker or base have moved.
/// The last of the session's resumptions has what was found.
///
/// Error: the poses cannot be seen, or no motion of the tracker explains where they are now, or too few of
/// them are there to tell.
CampaignOutcome<void> find_what_moved(MeasuringSession& session);

}  // namespace truepose::daemon
