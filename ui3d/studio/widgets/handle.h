#pragma once
// What can be grabbed: a shape in the picture, and how it follows the hand.

#include <optional>
#include <string_view>
#include <vector>

#include "ui3d/studio/widgets/subject.h"
#include "ui3d/studio/widgets/widgets.h"

namespace argil::studio {

/// How a handle follows the hand.
enum class Way : uint8_t {
  free,        ///< In the plane of the picture; over clay on its surface where the handle asks for that.
  along,       ///< On the line through it along `axis`.
  inPlane,     ///< In the plane through it normal to `axis`.
  about,       ///< Turns about `axis` through `anchor`.
  scaleAlong,  ///< By how far it is from `anchor` along `axis`.
  scaleAll,    ///< By how far it is from `anchor` in the picture.
  scaleBox,    ///< As scaleAlong, about `middle` instead of `anchor` while a key is held (Grip::snapOff).
};

/// What a drag has come to: the move in world mm, the turn in rad, the factor.
struct Change {
  Vec3d move = Vec3d::Zero();
  double angle = 0;
  double factor = 1;
  std::optional<Vec3d> about = {};  ///< A centre of the scale other than the handle's anchor.
};

enum class Form : uint8_t {
  dot,     ///< At points[0], of constant size.
  square,  ///< The same, square: scales.
  arrow,   ///< From points.front() to points.back(), with a head.
  path,    ///< A line along the points.
  area,    ///< Triangles, three points each.
  unseen,  ///< A path that is drawn by something else.
};

struct Handle {
  Target target;
  std::string_view name;  ///< With target and index it names the handle from frame to frame.
  int index = 0;
  Way way = Way::free;
  Vec3d anchor = Vec3d::Zero();  ///< What snaps; centre of turns and scales.
  Vec3d axis = Vec3d::UnitZ();   ///< Unit length.
  Vec3d middle = Vec3d::Zero();  ///< The other centre of Way::scaleBox.
  Form form = Form::dot;
  std::vector<Vec3d> points;
  render::Colour colour;
  bool body = false;          ///< Grabbed only where no other handle is.
  bool besideClay = false;    ///< Grabbed only where no clay is under the hand.
  bool toSurface = false;     ///< A free one that rests on clay.
  bool anchorIsGrab = false;  ///< The anchor is where it was grabbed.
  bool aligns = false;        ///< Snaps to what lies beside its way too: a plane to a point that it would go through.
  std::vector<Vec3d> beside;  ///< Right angles are looked for from these.
  /// Changes the subject as it was when the drag began.
  void (*apply)(Subject& subject, const Handle& handle, const Change& change) = nullptr;

  [[nodiscard]] bool same(const Handle& other) const {
    return target == other.target && name == other.name && index == other.index;
  }
};

/// Moves or turns all of the subject: what most handles do.
void applyRigid(Subject& subject, const Handle& handle, const Change& change);

inline constexpr double kPickUnits = 8;  ///< Interface units around a handle that a mouse grabs.

/// The handle that a hand would grab, and where. Nearest wins, handles before bodies. `clayThere`: there is clay under
/// the hand; asked once at most.
struct Picked {
  size_t index = 0;  ///< In `handles`.
  Vec3d point = Vec3d::Zero();
};
[[nodiscard]] std::optional<Picked> pickHandle(const std::vector<Handle>& handles, const Grip& grip,
                                               const ScreenMap& screen, double tipReachMm,
                                               const std::function<bool()>& clayThere);

}  // namespace argil::studio
