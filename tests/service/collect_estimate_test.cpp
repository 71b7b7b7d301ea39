// The estimate that goes along with a collection.
#include <gtest/gtest.h>

#include "session/bundle.h"
#include "session/rig_file.h"
#include "tests/support/live_rig.h"

namespace sixdial::service {
namespace {

using testing::LineClient;
using testing::Rig;
using testing::RunningService;
using testing::start;
using testing::wait_for_end;

TEST(Collect, TheEstimateSeesTheRigWhereItsFileSaysHowWellItIsKnown) {
  Rig rig;
  geometry::Rig file = session::parse_rig(rig.toml(), "rig.toml");
  for (geometry::Dial& dial : file.dials) {
    dial.deviations.position_mm = Eigen::Vector2d(0.03, 0.1);
  }
  RunningService running({}, rig.service_options());
  LineClient client = running.client();
  client.call("session.create", {{"name", "live"}, {"rig_toml", session::write_rig(file)}});
  start(client, Rig::plan(20));
  for (const bool again : {false, true}) {
    if (again) client.call("collect.start", {{"session", "live"}});  // nothing is left to do
    const Json estimate = wait_for_end(client)["estimate"];
    ASSERT_EQ(estimate["samples"], 20);
    const double of_rig_mm = estimate["position_sd_mm"]["of_rig"].get<double>();
    EXPECT_GT(of_rig_mm, 0.005);
    EXPECT_LT(of_rig_mm, estimate["position_sd_mm"]["max"].get<double>());
    ASSERT_EQ(estimate.at("rig").size(), 2 * file.dials.size());
    for (const Json& each : estimate["rig"]) {
      EXPECT_LT(each["sd"].get<double>(), 1.001 * each["known_sd"].get<double>()) << each;
    }
  }
}

}  // namespace
}  // namespace sixdial::service
