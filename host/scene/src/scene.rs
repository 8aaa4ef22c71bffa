//! A checked scene and the exact answer to "what does this ray meet?".

use crate::check;
use crate::contact::{Contact, Seen};
use crate::description::SceneDescription;
use crate::error::Error;
use crate::medium::{Medium, Water};
use crate::panel::Panel;
use crate::pool::Basin;
use crate::ray::Ray;
use crate::solid::Body;
use crate::surface::{Split, Waves, split};
use nalgebra::{Point3, Vector3};

/// A pool ready for tracing: every number was checked when it was made.
#[derive(Debug, Clone)]
pub struct Scene {
    pub(crate) basin: Basin,
    pub(crate) water: Option<(Water, Waves)>,
    /// Boards, then markers.
    pub(crate) panels: Vec<Panel>,
    pub(crate) bodies: Vec<Body>,
    boards: usize,
}

/// What a ray meets first.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// What it is.
    pub seen: Seen,
    /// Distance from the ray's origin, m; infinite for [`Seen::Hall`].
    pub range_m: f64,
    /// Coordinates on the surface that was met, m; [`Seen`] says which. 0, 0 for the hall.
    pub surface_m: [f64; 2],
}

impl Scene {
    /// Checks a description and prepares it.
    ///
    /// # Errors
    /// The first value that is outside the range stated where it is declared, with its path.
    pub fn new(description: &SceneDescription) -> Result<Self, Error> {
        check::description(description)?;
        let boards = description
            .boards
            .iter()
            .enumerate()
            .map(|(k, b)| Panel::board(k, b));
        let markers = description
            .markers
            .iter()
            .enumerate()
            .map(|(k, m)| Panel::marker(k, m));
        Ok(Self {
            basin: Basin::new(&description.pool, description.texture_seed),
            water: match description.medium {
                Medium::Air => None,
                Medium::Water(water) => Some((water, Waves::new(water.wave_slope))),
            },
            panels: boards.chain(markers).collect(),
            bodies: description
                .solids
                .iter()
                .enumerate()
                .map(|(k, s)| Body::new(k, s))
                .collect(),
            boards: description.boards.len(),
        })
    }

    /// What a ray meets first, exactly.
    ///
    /// # Errors
    /// [`Error::RayNotFinite`], and [`Error::RayOutside`] for a ray that does not start inside the
    /// water (or, without water, inside the basin up to its rim).
    pub fn trace(&self, ray: &Ray) -> Result<Hit, Error> {
        self.check(ray)?;
        Ok(match self.cast(ray) {
            Some(contact) => Hit {
                seen: contact.seen,
                range_m: contact.range_m,
                surface_m: contact.uv_m,
            },
            None => Hit {
                seen: Seen::Hall,
                range_m: f64::INFINITY,
                surface_m: [0.0, 0.0],
            },
        })
    }

    /// Linear relative radiance (red, green, blue) that arrives along a ray, averaged over a cone
    /// of `cone_rad` across: patterns finer than the cone are drawn as their mean. 0 is allowed.
    ///
    /// # Errors
    /// As [`Scene::trace`].
    pub fn radiance(&self, ray: &Ray, cone_rad: f64) -> Result<[f64; 3], Error> {
        self.check(ray)?;
        check::within("cone_rad", cone_rad, [0.0, std::f64::consts::PI])?;
        Ok(self.shade(ray, cone_rad).into())
    }

    /// World position of inner corner `(i, j)` (column, row, 0-based from the top left) of a board.
    /// `None` for a board or corner that is not there.
    pub fn board_corner_m(&self, board: usize, i: u32, j: u32) -> Option<Point3<f64>> {
        let panel = self.panels[..self.boards].get(board)?;
        let [columns, rows] = panel.cells();
        (i < columns - 1 && j < rows - 1).then(|| panel.grid_corner(i + 1, j + 1))
    }

    /// World positions of a marker's outer black corners: top left, top right, bottom right, bottom
    /// left as one reads it (OpenCV's order). `None` for a marker that is not there.
    pub fn marker_corners_m(&self, marker: usize) -> Option<[Point3<f64>; 4]> {
        let panel = self.panels[self.boards..].get(marker)?;
        Some([(0, 0), (6, 0), (6, 6), (0, 6)].map(|(i, j)| panel.grid_corner(i, j)))
    }

    pub(crate) fn panel(&self, seen: Seen) -> Option<&Panel> {
        match seen {
            Seen::Board(k) => self.panels.get(k),
            Seen::Marker(k) => self.panels.get(self.boards + k),
            _ => None,
        }
    }

    pub(crate) fn check(&self, ray: &Ray) -> Result<(), Error> {
        let origin_m: [f64; 3] = ray.origin_m.into();
        if !ray.is_finite() {
            return Err(Error::RayNotFinite {
                origin_m,
                direction: ray.direction.into_inner().into(),
            });
        }
        let mut half_m: [f64; 3] = self.basin.half_m.into();
        let top = if self.water.is_some() {
            half_m[2]
        } else {
            self.basin.rim_z_m
        };
        let inside = origin_m[0].abs() < half_m[0]
            && origin_m[1].abs() < half_m[1]
            && -half_m[2] < origin_m[2]
            && origin_m[2] < top;
        if inside {
            return Ok(());
        }
        half_m[2] = top;
        Err(Error::RayOutside {
            origin_m,
            half_size_m: half_m,
        })
    }

    /// The nearest contact of a ray that starts in the basin; `None` is the hall.
    pub(crate) fn cast(&self, ray: &Ray) -> Option<Contact> {
        let end = match self.surface_range(ray) {
            Some(range_m) => Some(self.surface_contact(ray, range_m)),
            None => self.basin.meet(ray),
        };
        self.nearest_thing(ray, end.map_or(f64::INFINITY, |c| c.range_m))
            .or(end)
    }

    /// The nearest panel or solid within `max_range_m`.
    pub(crate) fn nearest_thing(&self, ray: &Ray, mut max_range_m: f64) -> Option<Contact> {
        let (mut panel, mut body) = (None, None);
        for candidate in &self.panels {
            if let Some(range_m) = candidate.range_m(ray, max_range_m) {
                max_range_m = range_m;
                panel = Some(candidate);
            }
        }
        for candidate in &self.bodies {
            if let Some(range_m) = candidate.range_m(ray, max_range_m) {
                max_range_m = range_m;
                body = Some(candidate);
            }
        }
        // A body that was found lies before any panel that was found.
        body.map(|b| b.contact(ray, max_range_m))
            .or(panel.map(|p| p.contact(ray, max_range_m)))
    }

    /// Whether anything stands between a point and the lamps.
    pub(crate) fn in_shadow(&self, ray: &Ray) -> bool {
        self.panels
            .iter()
            .any(|panel| panel.range_m(ray, f64::INFINITY).is_some())
            || self
                .bodies
                .iter()
                .any(|body| body.range_m(ray, f64::INFINITY).is_some())
    }

    /// Range at which a ray reaches the water surface before any wall.
    fn surface_range(&self, ray: &Ray) -> Option<f64> {
        self.water.as_ref()?;
        let range_m = (self.basin.half_m.z - ray.origin_m.z) / ray.direction.z;
        if !(ray.direction.z > 0.0 && range_m.is_finite()) {
            return None;
        }
        let at = ray.at(range_m);
        (at.x.abs() < self.basin.half_m.x && at.y.abs() < self.basin.half_m.y).then_some(range_m)
    }

    fn surface_contact(&self, ray: &Ray, range_m: f64) -> Contact {
        let point = ray.at(range_m);
        let mirror = self
            .split_at(ray.direction.into_inner(), &point, 0.0)
            .is_some_and(|split| split.refracted.is_none());
        Contact {
            seen: if mirror { Seen::Mirror } else { Seen::Window },
            range_m,
            point,
            normal: -Vector3::z(),
            u_axis: Vector3::x(),
            v_axis: Vector3::y(),
            uv_m: [point.x, point.y],
        }
    }

    /// What the surface does at `point` with light along `direction`; `None` without water.
    pub(crate) fn split_at(
        &self,
        direction: Vector3<f64>,
        point: &Point3<f64>,
        footprint_m: f64,
    ) -> Option<Split> {
        let (water, waves) = self.water.as_ref()?;
        let normal = waves.normal(point.x, point.y, footprint_m);
        Some(split(direction, normal, water.refractive_index))
    }
}
