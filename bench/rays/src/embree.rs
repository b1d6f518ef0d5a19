//! The part of Embree 4's C interface that is measured, loaded at run time. The declarations follow `rtcore*.h` of
//! Embree 4.4 (<https://github.com/RenderKit/embree>).

use etendue_accel::Ray;
use libloading::Library;
use std::ffi::{CString, c_char, c_int, c_uint, c_void};
use std::mem::ManuallyDrop;
use std::path::Path;
use std::sync::atomic::{AtomicI64, Ordering};

use crate::mesh::Mesh;

/// How much effort a build takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Quality {
    /// Morton order.
    Low = 0,
    /// Binned SAH, the default.
    Medium = 1,
    /// With spatial splits.
    High = 2,
}

impl Quality {
    pub const ALL: [Self; 3] = [Self::Low, Self::Medium, Self::High];

    pub fn name(self) -> &'static str {
        match self {
            Self::Low => "low",
            Self::Medium => "medium",
            Self::High => "high",
        }
    }
}

/// Invalid geometry id.
const NOTHING: u32 = u32::MAX;

const TRIANGLES: c_uint = 0;
const BUFFER_INDEX: c_uint = 0;
const BUFFER_VERTEX: c_uint = 1;
const FORMAT_UINT3: c_uint = 0x5003;
const FORMAT_FLOAT3: c_uint = 0x9003;
const FLAG_COHERENT: u32 = 1 << 16;

type Object = *mut c_void;
type Monitor = extern "C" fn(*mut c_void, isize, bool) -> bool;

/// `RTCIntersectArguments` and `RTCOccludedArguments`, which have the same layout, with room for later members.
#[repr(C)]
struct Arguments {
    flags: u32,
    features: u32,
    pointers: [usize; 4],
}

impl Arguments {
    fn new(coherent: bool) -> Self {
        Self { flags: if coherent { FLAG_COHERENT } else { 0 }, features: u32::MAX, pointers: [0; 4] }
    }
}

/// `RTCRayHit`, `RTCRayHit8` or `RTCRayHit16`: every member N times. Aligned for the widest.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
pub struct Packet<const N: usize> {
    pub rays: Rays<N>,
    normal: [[f32; N]; 3],
    u: [f32; N],
    v: [f32; N],
    primitive: [u32; N],
    geometry: [u32; N],
    instance: [[u32; N]; 2],
}

/// `RTCRay`, `RTCRay8` or `RTCRay16`.
#[repr(C, align(16))]
#[derive(Clone, Copy)]
pub struct Rays<const N: usize> {
    origin: [[f32; N]; 3],
    near: [f32; N],
    direction: [[f32; N]; 3],
    time: [f32; N],
    far: [f32; N],
    mask: [u32; N],
    id: [u32; N],
    flags: [u32; N],
}

impl<const N: usize> Rays<N> {
    /// Up to N rays; missing ones have an empty range.
    pub fn new(rays: &[Ray]) -> Self {
        let mut packet = Self {
            origin: [[0.0; N]; 3],
            near: [1.0; N],
            direction: [[0.0; N], [0.0; N], [1.0; N]],
            time: [0.0; N],
            far: [0.0; N],
            mask: [u32::MAX; N],
            id: [0; N],
            flags: [0; N],
        };
        for (i, ray) in rays.iter().enumerate() {
            for axis in 0..3 {
                packet.origin[axis][i] = ray.origin[axis];
                packet.direction[axis][i] = ray.direction[axis];
            }
            (packet.near[i], packet.far[i]) = (ray.t_min, ray.t_max);
        }
        packet
    }
}

/// What a ray found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    pub t: f32,
    pub u: f32,
    pub v: f32,
    /// `u32::MAX` for a miss.
    pub geometry: u32,
    pub primitive: u32,
    pub normal: [f32; 3],
}

impl Found {
    pub const MISS: Self =
        Self { t: f32::INFINITY, u: 0.0, v: 0.0, geometry: NOTHING, primitive: NOTHING, normal: [0.0; 3] };

    pub fn is_hit(&self) -> bool {
        self.geometry != NOTHING
    }
}

impl<const N: usize> Packet<N> {
    #[inline(always)]
    fn new(rays: &Rays<N>) -> Self {
        Self {
            rays: *rays,
            normal: [[0.0; N]; 3],
            u: [0.0; N],
            v: [0.0; N],
            primitive: [NOTHING; N],
            geometry: [NOTHING; N],
            instance: [[NOTHING; N]; 2],
        }
    }

    #[inline(always)]
    fn found(&self, i: usize) -> Found {
        Found {
            t: self.rays.far[i],
            u: self.u[i],
            v: self.v[i],
            geometry: self.geometry[i],
            primitive: self.primitive[i],
            normal: [self.normal[0][i], self.normal[1][i], self.normal[2][i]],
        }
    }
}

/// The functions of the library, and a device.
pub struct Embree {
    intersect1: unsafe extern "C" fn(Object, *mut Packet<1>, *mut Arguments),
    intersect8: unsafe extern "C" fn(*const c_int, Object, *mut Packet<8>, *mut Arguments),
    intersect16: unsafe extern "C" fn(*const c_int, Object, *mut Packet<16>, *mut Arguments),
    occluded1: unsafe extern "C" fn(Object, *mut Rays<1>, *mut Arguments),
    occluded8: unsafe extern "C" fn(*const c_int, Object, *mut Wide<8>, *mut Arguments),
    occluded16: unsafe extern "C" fn(*const c_int, Object, *mut Wide<16>, *mut Arguments),
    new_scene: unsafe extern "C" fn(Object) -> Object,
    scene_quality: unsafe extern "C" fn(Object, c_uint),
    commit_scene: unsafe extern "C" fn(Object),
    release_scene: unsafe extern "C" fn(Object),
    new_geometry: unsafe extern "C" fn(Object, c_uint) -> Object,
    geometry_quality: unsafe extern "C" fn(Object, c_uint),
    set_buffer: unsafe extern "C" fn(Object, c_uint, c_uint, c_uint, *const c_void, usize, usize, usize),
    commit_geometry: unsafe extern "C" fn(Object),
    attach_geometry: unsafe extern "C" fn(Object, Object) -> c_uint,
    release_geometry: unsafe extern "C" fn(Object),
    device_error: unsafe extern "C" fn(Object) -> c_uint,
    release_device: unsafe extern "C" fn(Object),
    device: Object,
    /// Bytes that the device holds.
    held: Box<AtomicI64>,
}

/// Rays of a packet, aligned as `rtcOccluded16` wants them.
#[repr(C, align(64))]
#[derive(Clone, Copy)]
struct Wide<const N: usize>(Rays<N>);

// SAFETY: Embree's devices and scenes may be used by any thread; the pointer to the device is never written.
unsafe impl Sync for Embree {}

extern "C" fn count_bytes(held: *mut c_void, bytes: isize, _after: bool) -> bool {
    // SAFETY: `Embree::load` passes a pointer to an `AtomicI64` in a box that outlives the device.
    let held = unsafe { &*held.cast::<AtomicI64>() };
    held.fetch_add(bytes as i64, Ordering::Relaxed);
    true
}

impl Embree {
    /// Loads the library and makes a device whose builds use so many threads.
    pub fn load(path: &Path, threads: usize) -> Result<Self, String> {
        let failed = |e: libloading::Error| format!("{}: {e}", path.display());
        // SAFETY: the library is Embree, whose initialisers do nothing surprising.
        // Never unloaded: its threads may outlive the device.
        let library = ManuallyDrop::new(unsafe { Library::new(path) }.map_err(failed)?);
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the types are those of the functions in rtcore.h; the library stays loaded.
                *unsafe { library.get($name) }.map_err(failed)?
            };
        }
        let new_device: unsafe extern "C" fn(*const c_char) -> Object = function!(b"rtcNewDevice");
        let set_monitor: unsafe extern "C" fn(Object, Monitor, *mut c_void) =
            function!(b"rtcSetDeviceMemoryMonitorFunction");
        let config = CString::new(format!("threads={threads}")).map_err(|e| e.to_string())?;
        // SAFETY: the configuration ends with a zero byte.
        let device = unsafe { new_device(config.as_ptr()) };
        if device.is_null() {
            return Err(format!("{}: no device", path.display()));
        }
        let held = Box::new(AtomicI64::new(0));
        // SAFETY: the box outlives the device, see `Drop`.
        unsafe { set_monitor(device, count_bytes, (&raw const *held).cast_mut().cast()) };
        Ok(Self {
            intersect1: function!(b"rtcIntersect1"),
            intersect8: function!(b"rtcIntersect8"),
            intersect16: function!(b"rtcIntersect16"),
            occluded1: function!(b"rtcOccluded1"),
            occluded8: function!(b"rtcOccluded8"),
            occluded16: function!(b"rtcOccluded16"),
            new_scene: function!(b"rtcNewScene"),
            scene_quality: function!(b"rtcSetSceneBuildQuality"),
            commit_scene: function!(b"rtcCommitScene"),
            release_scene: function!(b"rtcReleaseScene"),
            new_geometry: function!(b"rtcNewGeometry"),
            geometry_quality: function!(b"rtcSetGeometryBuildQuality"),
            set_buffer: function!(b"rtcSetSharedGeometryBuffer"),
            commit_geometry: function!(b"rtcCommitGeometry"),
            attach_geometry: function!(b"rtcAttachGeometry"),
            release_geometry: function!(b"rtcReleaseGeometry"),
            device_error: function!(b"rtcGetDeviceError"),
            release_device: function!(b"rtcReleaseDevice"),
            device,
            held,
        })
    }

    /// Builds a scene of one mesh, whose arrays it shares.
    pub fn scene<'a>(&'a self, mesh: &'a Mesh, quality: Quality) -> Result<Scene<'a>, String> {
        let before = self.held.load(Ordering::Relaxed);
        // SAFETY: all objects are made by the functions that precede; the arrays live as long as the scene, hold as many
        // elements as is said, and are followed by at least the 4 bytes that Embree may read beyond a vertex
        // (`Mesh::positions` has one vertex more than is said).
        let (scene, error) = unsafe {
            let scene = (self.new_scene)(self.device);
            (self.scene_quality)(scene, quality as c_uint);
            let geometry = (self.new_geometry)(self.device, TRIANGLES);
            (self.geometry_quality)(geometry, quality as c_uint);
            let (vertices, faces) = (mesh.positions(), mesh.indices());
            (self.set_buffer)(
                geometry,
                BUFFER_VERTEX,
                0,
                FORMAT_FLOAT3,
                vertices.as_ptr().cast(),
                0,
                12,
                vertices.len() - 1,
            );
            (self.set_buffer)(geometry, BUFFER_INDEX, 0, FORMAT_UINT3, faces.as_ptr().cast(), 0, 12, faces.len());
            (self.commit_geometry)(geometry);
            (self.attach_geometry)(scene, geometry);
            (self.release_geometry)(geometry);
            (self.commit_scene)(scene);
            (scene, (self.device_error)(self.device))
        };
        let bytes = self.held.load(Ordering::Relaxed) - before;
        let scene = Scene { embree: self, scene, bytes };
        if error == 0 { Ok(scene) } else { Err(format!("Embree: error {error}")) }
    }
}

impl Drop for Embree {
    fn drop(&mut self) {
        // SAFETY: the device was made by `load`; scenes borrow `self`, so none is left.
        unsafe { (self.release_device)(self.device) }
    }
}

/// A built scene.
pub struct Scene<'a> {
    embree: &'a Embree,
    scene: Object,
    /// Bytes that it holds besides the mesh.
    pub bytes: i64,
}

// SAFETY: rays may be traced through a committed scene by any number of threads.
unsafe impl Sync for Scene<'_> {}

impl Drop for Scene<'_> {
    fn drop(&mut self) {
        // SAFETY: the scene was made by `Embree::scene` and is released once.
        unsafe { (self.embree.release_scene)(self.scene) }
    }
}

const ALL_VALID: Wide<16> = Wide(Rays {
    origin: [[0.0; 16]; 3],
    near: [0.0; 16],
    direction: [[0.0; 16]; 3],
    time: [0.0; 16],
    far: [0.0; 16],
    mask: [u32::MAX; 16],
    id: [0; 16],
    flags: [0; 16],
});

static VALID: Wide<16> = ALL_VALID;

/// As many -1 as there are rays in the widest packet, aligned.
fn valid() -> *const c_int {
    VALID.0.mask.as_ptr().cast()
}

impl Scene<'_> {
    /// `rtcIntersect1` for each ray.
    pub fn closest1(&self, rays: &[Ray], found: &mut [Found]) {
        let mut arguments = Arguments::new(false);
        for (ray, found) in rays.iter().zip(found) {
            let mut packet = Packet::new(&Rays::<1>::new(std::slice::from_ref(ray)));
            // SAFETY: the scene is committed, the packet is laid out and aligned as Embree wants it.
            unsafe { (self.embree.intersect1)(self.scene, &mut packet, &mut arguments) };
            *found = packet.found(0);
        }
    }

    /// `rtcIntersect8` for each packet.
    pub fn closest8(&self, packets: &[Rays<8>], found: &mut [Found], coherent: bool) {
        let call = self.embree.intersect8;
        self.closest_packets(packets, found, coherent, |valid, scene, packet, arguments| {
            // SAFETY: as in `closest1`; `valid` points to 16 aligned numbers.
            unsafe { call(valid, scene, packet, arguments) }
        });
    }

    /// `rtcIntersect16` for each packet.
    pub fn closest16(&self, packets: &[Rays<16>], found: &mut [Found], coherent: bool) {
        let call = self.embree.intersect16;
        self.closest_packets(packets, found, coherent, |valid, scene, packet, arguments| {
            // SAFETY: as in `closest8`.
            unsafe { call(valid, scene, packet, arguments) }
        });
    }

    fn closest_packets<const N: usize>(
        &self,
        packets: &[Rays<N>],
        found: &mut [Found],
        coherent: bool,
        call: impl Fn(*const c_int, Object, *mut Packet<N>, *mut Arguments),
    ) {
        let mut arguments = Arguments::new(coherent);
        for (rays, found) in packets.iter().zip(found.chunks_mut(N)) {
            let mut packet = Packet::new(rays);
            call(valid(), self.scene, &mut packet, &mut arguments);
            for (i, found) in found.iter_mut().enumerate() {
                *found = packet.found(i);
            }
        }
    }

    /// `rtcOccluded1` for each ray.
    pub fn any1(&self, rays: &[Ray], occluded: &mut [bool]) {
        let mut arguments = Arguments::new(false);
        for (ray, occluded) in rays.iter().zip(occluded) {
            let mut single = Rays::<1>::new(std::slice::from_ref(ray));
            // SAFETY: as in `closest1`.
            unsafe { (self.embree.occluded1)(self.scene, &mut single, &mut arguments) };
            *occluded = single.far[0] < 0.0;
        }
    }

    /// `rtcOccluded8` for each packet.
    pub fn any8(&self, packets: &[Rays<8>], occluded: &mut [bool]) {
        let call = self.embree.occluded8;
        self.any_packets(packets, occluded, |valid, scene, packet, arguments| {
            // SAFETY: as in `closest8`.
            unsafe { call(valid, scene, packet, arguments) }
        });
    }

    /// `rtcOccluded16` for each packet.
    pub fn any16(&self, packets: &[Rays<16>], occluded: &mut [bool]) {
        let call = self.embree.occluded16;
        self.any_packets(packets, occluded, |valid, scene, packet, arguments| {
            // SAFETY: as in `closest8`.
            unsafe { call(valid, scene, packet, arguments) }
        });
    }

    fn any_packets<const N: usize>(
        &self,
        packets: &[Rays<N>],
        occluded: &mut [bool],
        call: impl Fn(*const c_int, Object, *mut Wide<N>, *mut Arguments),
    ) {
        let mut arguments = Arguments::new(false);
        for (rays, occluded) in packets.iter().zip(occluded.chunks_mut(N)) {
            let mut packet = Wide(*rays);
            call(valid(), self.scene, &mut packet, &mut arguments);
            for (far, occluded) in packet.0.far.iter().zip(occluded) {
                *occluded = *far < 0.0;
            }
        }
    }
}
