#pragma once
// Where strokes trade accuracy for speed.

namespace argil::clay {

/// The same for a whole stroke, and part of what its result follows from. What stands here is the balanced preset's;
/// docs/tradeoff.md has what each buys. Lengths are in voxels.
struct Quality {
  /// What a distance may be off from what redistancing finds and stay as it is; a fifth of it where slopes are renewed,
  /// a fiftieth where everything is of second order. 0.01 to 1.
  double tolerance = 0.1;
  /// Of redistancing: 1 to 16; 0: as many as the whole band needs, which raising without a limit always takes. Fewer
  /// leave the far part of the band as it was.
  int passes = 0;
  /// A brick whose distances may have changed by more since they were renewed is renewed at once, before the band is
  /// used up: 0.25 to 2.
  double drift = 1;
  /// Stamps by which redistancing trails the tool: 1 to 32. More touch a brick once where fewer renew it several times.
  int trail = 2;
  /// Stamps that move clay by no more than this altogether are computed at once, four at most: 0 (never) to 48. Tips of
  /// more than 30 voxels move it by as much more as they are larger. A large smoothing stamp counts as the width of the
  /// band.
  double together = 12;
  /// Of the flow that moves clay, in radii of the tip, what one step follows: 0.02 to 1.
  double flowStep = 0.12;
  /// Means of the surface that scrape, fill and flatten take their plane from, each weighed by the one before: 1 to 8.
  /// Of a wall as large as what it stands beside nothing is left after the third.
  int levelRounds = 3;

  /// Throws Error for what is out of range or no number.
  void check() const;
  friend bool operator==(const Quality&, const Quality&) = default;
};

}  // namespace argil::clay
