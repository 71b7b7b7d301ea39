// Laws that every instrument kind of the registry keeps, and one more that is added at run
// time.
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <set>

#include "geometry/instrument_kind.h"
#include "geometry/rig.h"
#include "geometry/rotation.h"
#include "geometry/units.h"

namespace sixdial::geometry {
namespace {

constexpr double kRelative = 1e-7;

// A wire from an anchor to the tool: one channel, three parameters.
tl::expected<std::shared_ptr<const InstrumentModel>, std::string> wire_of(const Rig& /*rig*/) {
  auto result = std::make_shared<InstrumentModel>();
  result->kind = find_instrument_kind("test_wire");
  result->channels = {{"wire", "mm", 0.01}};
  for (const char* name : {"anchor_x", "anchor_y", "wire_zero"}) {
    result->parameters.push_back({name, "", "mm"});
  }
  result->nominal = Eigen::Vector3d(-100, 20, 5);
  result->known_to = Eigen::Vector3d(1, 1, HUGE_VAL);
  return result;
}
void observe_wire(
    const InstrumentModel& /*instrument*/, std::span<const double> x,
    std::span<const double> /*unknowns*/, std::span<const Pose<double>> X, bool say_shown,
    Observation& out) {
  const Eigen::Vector3d along = X[0].p - Eigen::Vector3d(x[0], x[1], 0.0);
  out.reading = Eigen::VectorXd::Constant(1, along.norm() + x[2]);
  out.by_frames.setZero(1, 6 * static_cast<Eigen::Index>(X.size()));
  out.by_frames.leftCols<3>() = along.normalized().transpose();
  out.by_x = Eigen::RowVector3d(-along.x() / along.norm(), -along.y() / along.norm(), 1.0);
  out.by_unknowns.resize(1, 0);
  if (say_shown) out.shows = {true};
}

std::vector<const InstrumentKind*> every_kind() {
  static const InstrumentKind& wire = add_instrument_kind(
      {.name = "test_wire",
       .in_words = "draw wire",
       .of_rig = wire_of,
       .observe = observe_wire});
  (void)wire;
  return {instrument_kinds().begin(), instrument_kinds().end()};
}

/// A kind on the standard rig; `mount` matters to those that hold a cuboid.
struct Case {
  const InstrumentKind* kind;
  Mount mount;
};
std::vector<Case> every_case() {
  std::vector<Case> cases;
  for (const InstrumentKind* kind : every_kind()) {
    for (const Mount mount : {Mount::kDistal1, Mount::kDistal2, Mount::kFree}) {
      cases.push_back({kind, mount});
    }
  }
  return cases;
}

class EveryInstrument : public testing::TestWithParam<Case> {
 protected:
  EveryInstrument() {
    rig_ = default_rig();
    rig_.cuboid.mount = GetParam().mount;
    rig_.instrument.kind = GetParam().kind->name;
    const std::string kind = rig_.instrument.kind;
    on_cuboid_ = kind == "dials_on_cuboid";
    if (!on_cuboid_) rig_.instrument.dimensions = 3;
    // Two of each, one known exactly and one not at all.
    rig_.instrument.tool_points = {{"P2", Eigen::Vector3d(10, 20, 30)}, {.name = "P3"}};
    rig_.instrument.anchors = {
        {"K1", Eigen::Vector3d(500, -200, 300), 0.2},
        {.name = "K2"},
        {"K3", Eigen::Vector3d(0, 700, 100)}};
    rig_.instrument.sockets = {{.name = "S1"}, {.name = "S2"}};
    rig_.instrument.socket_distances = {{"S1", "S2", 50.0, 0.1}};
    rig_.instrument.surfaces = {
        {.place = {.name = "bed"}, .normal = Eigen::Vector3d(0.6, 0.0, 0.8)},
        {.place = {"ball", Eigen::Vector3d(100, 0, 0), 0.5}, .radius_mm = 20.0}};
    instrument_ = instrument_of(rig_);
  }

  /// Frames near the middle of the workspace, each turned and moved a little on its own.
  std::vector<Pose<double>> frames() {
    std::vector<Pose<double>> X(rig_.robot.model->frames.size());
    for (Pose<double>& each : X) {
      each.p = {within(20, 36), within(36, 60), 0.0};
      const double turn = within(-0.1, 0.1);
      if (!on_cuboid_) {
        each.p.z() = within(-20, 20);
        each.R = turned_by<double>(
            Eigen::Vector3d(within(-1.5, 1.5), within(-1.5, 1.5), within(-1.5, 1.5)));
        continue;
      }
      each.R.topLeftCorner<2, 2>() << std::cos(turn), -std::sin(turn), std::sin(turn),
          std::cos(turn);
    }
    return X;
  }
  double within(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random_);
  }
  Observation observe(
      const std::vector<Pose<double>>& X, const Eigen::VectorXd& x,
      std::optional<double> unknown = std::nullopt) {
    Observation out;
    const std::span<const double> unknowns =
        unknown ? std::span(&*unknown, 1) : std::span<const double>();
    GetParam().kind->observe(
        *instrument_, {x.data(), static_cast<std::size_t>(x.size())}, unknowns, X, true, out);
    return out;
  }

  Rig rig_;
  std::shared_ptr<const InstrumentModel> instrument_;
  bool on_cuboid_ = false;
  std::mt19937_64 random_{77};
};

TEST_P(EveryInstrument, SaysWhatItShows) {
  EXPECT_FALSE(GetParam().kind->in_words.empty());
  EXPECT_EQ(instrument_->kind, GetParam().kind);
  ASSERT_FALSE(instrument_->channels.empty());
  std::set<std::string> names;
  for (const ChannelInfo& channel : instrument_->channels) {
    EXPECT_TRUE(names.insert(channel.name).second) << channel.name;
    EXPECT_FALSE(channel.unit.empty()) << channel.name;
    EXPECT_GE(channel.sd, 0.0) << channel.name;
  }
  for (const ParameterInfo& parameter : instrument_->parameters) {
    EXPECT_TRUE(names.insert(parameter.name).second) << parameter.name;
    EXPECT_FALSE(rig_.robot.model->find_parameter(parameter.name)) << parameter.name;
    EXPECT_GT(parameter.change, 0.0) << parameter.name;
  }
  EXPECT_EQ(instrument_->nominal.size(), instrument_->parameter_count());
  ASSERT_EQ(instrument_->known_to.size(), instrument_->parameter_count());
  for (Eigen::Index i = 0; i < instrument_->known_to.size(); ++i) {
    EXPECT_GT(instrument_->known_to[i], 0.0);
  }
}

TEST_P(EveryInstrument, AnswersForEveryChannel) {
  const Observation seen = observe(frames(), instrument_->nominal);
  const Eigen::Index channels = instrument_->channel_count();
  EXPECT_EQ(seen.reading.size(), channels);
  EXPECT_TRUE(seen.reading.allFinite());
  EXPECT_EQ(seen.by_frames.rows(), channels);
  EXPECT_EQ(seen.by_frames.cols(), 6 * std::ssize(rig_.robot.model->frames));
  EXPECT_EQ(seen.by_x.rows(), channels);
  EXPECT_EQ(seen.by_x.cols(), instrument_->parameter_count());
  EXPECT_EQ(static_cast<Eigen::Index>(seen.shows.size()), channels);
}

TEST_P(EveryInstrument, DerivativesAreThoseOfTheReadings) {
  for (int i = 0; i < 300; ++i) {
    const auto X = frames();
    Eigen::VectorXd x = instrument_->nominal;
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      x[k] += within(-1, 1) * instrument_->parameters[static_cast<std::size_t>(k)].change;
    }
    const Observation exact = observe(X, x);
    const auto compare = [&](const Eigen::VectorXd& expected, double step, auto&& reading_at,
                             const std::string& what) {
      const Eigen::VectorXd slope = (8 * (reading_at(step) - reading_at(-step)) -
                                     (reading_at(2 * step) - reading_at(-2 * step))) /
                                    (12 * step);
      ASSERT_LT((slope - expected).norm(), kRelative * std::max(1.0, expected.norm())) << what;
    };
    for (std::size_t frame = 0; frame < X.size(); ++frame) {
      for (int axis = 0; axis < 6; ++axis) {
        // Turns out of the plane are no motion of a cuboid that lies in it.
        if (on_cuboid_ && (axis == 3 || axis == 4)) continue;
        const auto reading_at = [&](double step) {
          auto moved = X;
          if (axis < 3) {
            moved[frame].p[axis] += step;
          } else {
            moved[frame].R =
                Eigen::AngleAxisd(step, Eigen::Vector3d::Unit(axis - 3)) * moved[frame].R;
          }
          return observe(moved, x).reading;
        };
        compare(
            exact.by_frames.col(6 * static_cast<Eigen::Index>(frame) + axis),
            axis < 3 ? 2e-3 : 2e-5, reading_at, rig_.robot.model->frames[frame]);
      }
    }
    for (Eigen::Index k = 0; k < x.size(); ++k) {
      const auto& info = instrument_->parameters[static_cast<std::size_t>(k)];
      const auto reading_at = [&](double step) {
        Eigen::VectorXd moved = x;
        moved[k] += step;
        return observe(X, moved).reading;
      };
      compare(exact.by_x.col(k), 1e-3 * info.change, reading_at, info.name);
    }
    if (instrument_->unknowns.empty()) continue;
    const double at = within(-0.2, 0.2);
    compare(
        observe(X, x, at).by_unknowns.col(0), 2e-5,
        [&](double step) { return observe(X, x, at + step).reading; },
        instrument_->unknowns[0].name);
  }
}

TEST_P(EveryInstrument, EveryParameterMovesAChannelAndTheToolMovesEveryChannel) {
  Eigen::VectorXd by_x = Eigen::VectorXd::Zero(instrument_->parameter_count());
  Eigen::VectorXd by_tool = Eigen::VectorXd::Zero(instrument_->channel_count());
  for (int i = 0; i < 20; ++i) {
    const Observation seen = observe(frames(), instrument_->nominal);
    by_x += seen.by_x.colwise().norm().transpose();
    by_tool += seen.by_frames.leftCols<6>().rowwise().norm();
  }
  for (Eigen::Index k = 0; k < by_x.size(); ++k) {
    EXPECT_GT(by_x[k], 1e-6) << instrument_->parameters[static_cast<std::size_t>(k)].name;
  }
  for (Eigen::Index i = 0; i < by_tool.size(); ++i) {
    EXPECT_GT(by_tool[i], 1e-6) << instrument_->channels[static_cast<std::size_t>(i)].name;
  }
}

// What is not known is found in closed form where the robot is exact.
TEST_P(EveryInstrument, StartsAtTheTruthOfAnExactRobot) {
  if (GetParam().kind->start == nullptr) return;
  Eigen::VectorXd truth = instrument_->nominal;
  for (Eigen::Index k = 0; k < truth.size(); ++k) {
    if (!std::isinf(instrument_->known_to[k])) continue;
    truth[k] =
        (instrument_->parameters[static_cast<std::size_t>(k)].unit == "rad" ? 0.01 : 40) *
        within(0.5, 1.0);
  }
  std::vector<std::vector<Pose<double>>> poses;
  std::vector<std::vector<std::optional<double>>> readings;
  for (int i = 0; i < 40; ++i) {
    auto X = frames();
    if (rig_.instrument.kind == "socket") {  // the tool sits in one of them
      X[0].p = truth.segment<3>(i % 2 == 0 ? 0 : 3);
    }
    const Observation seen = observe(X, truth);
    auto& reading = readings.emplace_back(seen.reading.begin(), seen.reading.end());
    for (std::size_t k = 0; k < reading.size(); ++k) {
      if (rig_.instrument.kind == "socket" && (k < 3) != (i % 2 == 0)) reading[k].reset();
    }
    poses.push_back(std::move(X));
  }
  std::vector<SeenSample> samples;
  for (std::size_t i = 0; i < poses.size(); ++i) samples.push_back({poses[i], readings[i]});
  Eigen::VectorXd x = instrument_->nominal;
  GetParam().kind->start(*instrument_, samples, x);
  EXPECT_LT((x - truth).cwiseAbs().maxCoeff(), 1e-6);
}

/// An instrument of poses at a frame that is turned by w.
class Pose : public testing::Test {
 protected:
  Pose() {
    rig_.instrument.kind = "pose";
    rig_.instrument.dimensions = 3;
    instrument_ = instrument_of(rig_);
  }
  Observation near(const Eigen::Vector3d& measured, const Eigen::Matrix3d& R) const {
    std::vector<sixdial::geometry::Pose<double>> X(rig_.robot.model->frames.size());
    X[0].R = R;
    Observation out;
    instrument_->kind->observe(*instrument_, {}, {}, X, false, out);
    const std::vector<std::optional<double>> read{0.,          0.,          0.,
                                                  measured[0], measured[1], measured[2]};
    instrument_->kind->nearest(read, out);
    return out;
  }

  Rig rig_ = default_rig();
  std::shared_ptr<const InstrumentModel> instrument_;
  std::mt19937_64 random_{7};
};

TEST_F(Pose, ARotationVectorIsTakenNearestToWhatWasMeasured) {
  // Half a turn and a bit about z: seen as 3.2, computed as 3.2 - 2 pi.
  const Eigen::Matrix3d R = turned_by<double>(Eigen::Vector3d(0, 0, 3.2));
  EXPECT_LT(rotation_vector(R)[2], 0.0);
  EXPECT_LT(std::abs(near({0.0, 0.0, 3.1}, R).reading[5] - 3.2), 1e-12);
}

TEST_F(Pose, WhatIsLeftIsTheTurnBetweenTheFramesHoweverFarBothAreTurned) {
  constexpr double kApart_rad = 1e-3;
  std::normal_distribution<double> normal;
  for (const double turned_deg : {0.0, 0.01, 90.0, 150.0, 179.9, 180.0, 180.1, 270.0, 355.0}) {
    for (int i = 0; i < 20; ++i) {
      const Eigen::Vector3d axis =
          Eigen::Vector3d(normal(random_), normal(random_), normal(random_)).normalized();
      const Eigen::Vector3d apart =
          kApart_rad *
          Eigen::Vector3d(normal(random_), normal(random_), normal(random_)).normalized();
      const Eigen::Vector3d measured = turned_deg * kRadPerDeg * axis;
      // The tool is turned by `apart` less than was measured.
      const Eigen::Matrix3d R = turned_by<double>(-apart) * turned_by<double>(measured);
      const Eigen::Vector3d left = measured - near(measured, R).reading.tail<3>();
      EXPECT_LT((left - apart).norm(), 1e-12) << turned_deg;
    }
  }
}

TEST_F(Pose, SlopesOfWhatIsLeftAreThoseOfTheTurnBetweenTheFrames) {
  for (const double turned_rad : {0.3, 2.9, 3.3, 6.1}) {
    for (const double apart_rad : {0.0, 1e-3, 0.4, 2.5}) {
      const Eigen::Vector3d measured = turned_rad * Eigen::Vector3d(0.6, -0.48, 0.64);
      const Eigen::Matrix3d R = turned_by<double>(apart_rad * Eigen::Vector3d(0.0, 0.6, 0.8)) *
                                turned_by<double>(measured);
      const Observation exact = near(measured, R);
      for (int axis = 0; axis < 3; ++axis) {
        const auto reading_at = [&](double step) -> Eigen::VectorXd {
          return near(measured, Eigen::AngleAxisd(step, Eigen::Vector3d::Unit(axis)) * R)
              .reading;
        };
        constexpr double kStep = 2e-4;
        const Eigen::VectorXd slope = (8 * (reading_at(kStep) - reading_at(-kStep)) -
                                       (reading_at(2 * kStep) - reading_at(-2 * kStep))) /
                                      (12 * kStep);
        EXPECT_LT((slope - exact.by_frames.col(3 + axis)).norm(), 1e-9)
            << turned_rad << ' ' << apart_rad << ' ' << axis;
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    , EveryInstrument, testing::ValuesIn(every_case()), [](const auto& each) {
      const char* mount = each.param.mount == Mount::kDistal1   ? "_distal1"
                          : each.param.mount == Mount::kDistal2 ? "_distal2"
                                                                : "_free";
      return std::string(each.param.kind->name) + mount;
    });

TEST(InstrumentKinds, ANameCanBeHadOnce) {
  InstrumentKind again = *find_instrument_kind("position");
  EXPECT_THROW(add_instrument_kind(again), std::invalid_argument);
  again.name = "position_without_observe";
  again.observe = nullptr;
  EXPECT_THROW(add_instrument_kind(again), std::invalid_argument);
}

TEST(InstrumentKinds, ARigSaysWhyItCannotHaveItsInstrument) {
  Rig rig = default_rig();
  rig.instrument.kind = "crystal_ball";
  EXPECT_THROW((void)instrument_of(rig), std::invalid_argument);
  rig = default_rig();
  rig.cuboid.reference_pose_mm = {900, 900};
  EXPECT_THROW((void)instrument_of(rig), std::invalid_argument);
}

}  // namespace
}  // namespace sixdial::geometry
