//! Everything that differs between Embree 3.13 and Embree 4, and nothing else.

use super::coherence::Coherence;
use super::sys;

/// What Embree 3 calls a context and Embree 4 calls arguments: the settings of one query. Embree 3 writes to
/// it during traversal, so a query belongs to one thread and one call at a time.
pub(super) struct Query {
    #[cfg(embree3)]
    context: sys::RTCIntersectContext,
    #[cfg(embree4)]
    context: sys::RTCRayQueryContext,
    #[cfg(embree4)]
    flags: sys::RTCRayQueryFlags,
}

#[cfg(embree3)]
impl Query {
    pub(crate) fn new(coherence: Coherence) -> Query {
        let flags = match coherence {
            Coherence::Coherent => sys::RTC_INTERSECT_CONTEXT_FLAG_COHERENT,
            Coherence::Incoherent => sys::RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT,
        };
        let mut context = sys::RTCIntersectContext { flags, ..Default::default() };
        context.instID = [u32::MAX];
        Query { context }
    }
}

#[cfg(embree4)]
impl Query {
    pub(crate) fn new(coherence: Coherence) -> Query {
        let flags = match coherence {
            Coherence::Coherent => sys::RTC_RAY_QUERY_FLAG_COHERENT,
            Coherence::Incoherent => sys::RTC_RAY_QUERY_FLAG_INCOHERENT,
        };
        let context = sys::RTCRayQueryContext { instID: [u32::MAX], ..Default::default() };
        Query { context, flags }
    }

    fn intersect_arguments(&mut self) -> sys::RTCIntersectArguments {
        sys::RTCIntersectArguments {
            flags: self.flags,
            feature_mask: sys::RTC_FEATURE_FLAG_ALL,
            context: &mut self.context,
            ..Default::default()
        }
    }

    fn occluded_arguments(&mut self) -> sys::RTCOccludedArguments {
        sys::RTCOccludedArguments {
            flags: self.flags,
            feature_mask: sys::RTC_FEATURE_FLAG_ALL,
            context: &mut self.context,
            ..Default::default()
        }
    }
}

/// Declares one query function for both majors.
macro_rules! query {
    ($name:ident, $function:ident, $arguments:ident, $ray:ty $(, $valid:ident)?) => {
        /// # Safety
        /// `scene` is committed and alive; `ray` and `valid` are aligned as their types say and writable; `valid`
        /// has as many readable elements as the packet has lanes.
        #[inline]
        pub(super) unsafe fn $name($($valid: *const i32,)? scene: sys::RTCScene, query: &mut Query, ray: *mut $ray) {
            // SAFETY: passed on from the caller; the settings live across the call.
            #[cfg(embree3)]
            unsafe { sys::$function($($valid,)? scene, &mut query.context, ray) }
            #[cfg(embree4)]
            {
                let mut arguments = query.$arguments();
                // SAFETY: as above.
                unsafe { sys::$function($($valid,)? scene, ray, &mut arguments) }
            }
        }
    };
}

query!(intersect1, rtcIntersect1, intersect_arguments, sys::RTCRayHit);
query!(intersect8, rtcIntersect8, intersect_arguments, sys::RTCRayHit8, valid);
query!(intersect16, rtcIntersect16, intersect_arguments, sys::RTCRayHit16, valid);
query!(occluded1, rtcOccluded1, occluded_arguments, sys::RTCRay);
query!(occluded8, rtcOccluded8, occluded_arguments, sys::RTCRay8, valid);
query!(occluded16, rtcOccluded16, occluded_arguments, sys::RTCRay16, valid);
